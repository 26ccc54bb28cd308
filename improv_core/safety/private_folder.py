"""Folders that only one user can enter, for sockets."""

from __future__ import annotations

import stat
from contextlib import suppress
from pathlib import Path


def private_folder(folder: Path, user: int) -> Path | None:
    """Return a folder, made if it is missing; None unless only this user has access."""
    with suppress(OSError):
        folder.mkdir(0o700, exist_ok=True)
    return folder if is_private(folder, user) else None


def is_private(folder: Path, user: int) -> bool:
    try:
        found = folder.lstat()
    except (OSError, ValueError):
        return False
    return stat.S_ISDIR(found.st_mode) and found.st_uid == user and not found.st_mode & 0o077
