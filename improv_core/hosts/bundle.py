"""The files that another machine gets once for each version: the modules that a ROS 2 stage needs, and the far end."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent
CONTENTS = (
    *("__init__.py", "plain.py", "slices.py", "text.py", "values.py"),
    *(f"{room}/*.py" for room in ("score", "protocol", "safety", "ipc", "player", "preview", "stage")),
    *("outputs/*.py", "outputs/ros/**/*.py", "outputs/ros/setup/requirements.txt"),
    *(f"hosts/{name}.py" for name in ("__init__", "__main__", "exclusive_use", "far", "far_setup", "frames")),
)
"""The parts of our package in it."""
_NO_DATE = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class Bundle:
    """A zip file, and its hash, by which the other machine recognizes a bundle that it has."""

    data: bytes
    digest: str


@lru_cache(maxsize=1)
def bundle() -> Bundle:
    """Return the bundle of this version: the same modules make the same bytes."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for path in sorted(path for pattern in CONTENTS for path in PACKAGE.glob(pattern)):
            entry = zipfile.ZipInfo((Path(PACKAGE.name) / path.relative_to(PACKAGE)).as_posix(), _NO_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o600 << 16
            made.writestr(entry, path.read_bytes())
    data = file.getvalue()
    return Bundle(data, hashlib.sha256(data).hexdigest())


def boot_line(carried: Bundle, arguments: Sequence[str]) -> bytes:
    """Return the first line to send: the source of `bootstrap`, and its arguments."""
    source = (PACKAGE / "hosts" / "bootstrap.py").read_text(encoding="utf-8")
    call = f"begin({carried.digest!r}, {len(carried.data)}, {[*arguments]!a})"
    return f"exec({source + call!a})\n".encode("ascii")
