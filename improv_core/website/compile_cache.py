"""The Python files of the website as a browser has compiled them, so that it need not compile them again."""

from __future__ import annotations

import io
import zipfile
from importlib.util import cache_from_source
from pathlib import Path


def compiled(folder: str) -> bytes:
    """Archive all files in a folder. Modules that Python has compiled there are without their source."""
    archive, root = io.BytesIO(), Path(folder)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_STORED) as file:
        for path in sorted(root.rglob("*")):
            if path.is_dir() or path.suffix == ".pyc":
                continue
            kept = Path(cache_from_source(str(path))) if path.suffix == ".py" else path
            name = path.relative_to(root).as_posix()
            if kept != path and kept.is_file():
                file.write(kept, f"{name}c")
            else:
                file.write(path, name)
    return archive.getvalue()
