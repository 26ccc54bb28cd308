"""The files that the browser loads."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

FOLDER = Path(__file__).parent / "static"
CONTENT_TYPES = {".css": "text/css", ".js": "text/javascript"}


def page_files(folder: Path = FOLDER) -> Mapping[str, Path]:
    """Return the scripts and styles in a folder, by their paths below it."""
    found = sorted(path for path in folder.rglob("*") if path.suffix in CONTENT_TYPES)
    return {path.relative_to(folder).as_posix(): path for path in found}
