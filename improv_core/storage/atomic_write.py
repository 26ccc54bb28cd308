"""Files that are complete as soon as they have their name, and that nobody can redirect."""

from __future__ import annotations

import errno
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


@contextmanager
def replacing(path: Path, *, private: bool = False) -> Iterator[BinaryIO]:
    """A new file that takes the place of `path` in one step at the end; if the body raises, nothing changes.

    Until then it has a random name in the same folder, only its owner can read it, and no link is followed. It gets
    the permissions of the file it replaces, unless it is to stay `private`. If `path` is a link, it stays one. Raises
    OSError.
    """
    target = path.resolve()
    check_replaceable(target)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")  # exclusively, with mode 0600
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
            file.flush()
            if sys.platform != "win32" and not private:
                os.fchmod(handle, target.stat().st_mode if target.exists() else usual_mode())
            os.fsync(handle)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def check_replaceable(target: Path) -> None:
    """Raise OSError if something is there that is no file, or may not be written."""
    if target.exists() and not target.is_file():
        raise FileExistsError(errno.EEXIST, "something else has that name")
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


def usual_mode() -> int:
    """The permissions that a new file gets here."""
    mask = os.umask(0o077)  # it can only be read by setting it
    os.umask(mask)
    return 0o666 & ~mask
