"""Files that are complete as soon as they have their name, and that nobody can redirect."""

from __future__ import annotations

import errno
import glob
import os
import secrets
import stat
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO


@contextmanager
def replacing(path: Path, *, private: bool = False) -> Iterator[BinaryIO]:
    """Yield a new file that replaces `path` in one step at the end; if the body raises, nothing changes.

    Until then only its owner can read it, and no link is followed. It gets the owner, the group, and the permissions of
    the file it replaces, unless it is to stay `private`. If `path` is a link, it stays one. Raises OSError.
    """
    with beside(real(path)) as new:
        yield new.file
        new.complete(private=private)
        remove_left(new.target)
        if not new.put():
            new.named().replace(new.target)


@contextmanager
def beside(target: Path) -> Iterator[NewFile]:
    """Yield a file that may replace another one. Raises OSError, also if nothing may replace that one."""
    check_replaceable(target)
    new = NewFile(target)
    try:
        yield new
    finally:
        new.close()


class NewFile:
    """A file that may replace another one, in the same folder.

    On Linux it has no name while it is written, so nothing of it stays if its process is killed. Elsewhere, and while
    two files change places, it has a hidden name and a lock, so that other processes recognize an abandoned file.
    """

    def __init__(self, target: Path) -> None:
        self.target = target
        self._hidden: Path | None = None
        self.file = self._opened()
        self._lock = _locked(str(self._hidden or f"/proc/self/fd/{self.file.fileno()}"))

    def complete(self, *, private: bool = False) -> None:
        """Finish writing. Raises OSError."""
        self.file.flush()
        if not private:
            _copy_attributes(self.file.fileno(), self.target)
        os.fsync(self.file.fileno())
        self.file.close()

    def put(self) -> bool:
        """Give it its name, unless another file has that name. Return whether it got the name. Raises OSError."""
        try:
            self._link(self.target)
        except FileExistsError:
            return False
        except OSError:  # this file system has no links
            self.named().replace(self.target)
        return True

    def named(self) -> Path:
        """Return its hidden name, and give it one if it has none. Raises OSError."""
        if not self._hidden:
            hidden = self.target.with_name(f"{_prefix(self.target)}{secrets.token_hex(4)}")
            self._link(hidden)
            self._hidden = hidden
        return self._hidden

    def close(self) -> None:
        """Remove the file with its hidden name."""
        self.file.close()
        if self._hidden:
            self._hidden.unlink(missing_ok=True)
        if self._lock is not None:
            os.close(self._lock)

    def _opened(self) -> BinaryIO:
        """Open it for writing, exclusively, and with mode 0600."""
        if sys.platform == "linux" and Path("/proc/self/fd").exists():
            try:
                return os.fdopen(os.open(self.target.parent, os.O_WRONLY | os.O_TMPFILE, 0o600), "wb")
            except OSError as error:
                if error.errno not in (errno.EOPNOTSUPP, errno.EISDIR, errno.EINVAL):  # not every file system has them
                    raise
        handle, name = tempfile.mkstemp(dir=self.target.parent, prefix=_prefix(self.target))
        self._hidden = Path(name)
        return os.fdopen(handle, "wb")

    def _link(self, name: Path) -> None:
        if self._hidden:
            os.link(self._hidden, name)
            return
        folder = os.open(name.parent, os.O_RDONLY)  # Python needs it to follow the link to an open file
        try:
            os.link(f"/proc/self/fd/{self._lock}", name.name, src_dir_fd=folder, dst_dir_fd=folder)
        finally:
            os.close(folder)


def remove_left(target: Path, keep: Callable[[bytes], None] = lambda text: None) -> None:
    """Remove the files that killed processes left beside a file. `keep` gets each text first: it may be the only copy
    of another program's text."""
    if sys.platform == "win32":
        return
    import fcntl

    for path in target.parent.glob(f"{glob.escape(_prefix(target))}*"):
        with suppress(OSError):  # another process uses it, or has removed it
            left = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            with os.fdopen(left, "rb") as file:
                fcntl.flock(left, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if stat.S_ISREG(os.fstat(left).st_mode):
                    keep(file.read(_MAX_KEPT))
                    path.unlink()


_MAX_KEPT = 10_000_000
"""Bytes of a text that is kept: no text that we write is longer."""


def check_replaceable(target: Path) -> None:
    """Raise OSError if the target exists but is no file, may not be written, or has further names."""
    if not target.exists():
        return
    if not target.is_file():
        raise FileExistsError(errno.EEXIST, "a folder or another special file has that name")
    if not os.access(target, os.W_OK):
        if sys.platform != "win32" and os.statvfs(target).f_flag & os.ST_RDONLY:
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    if (names := target.stat().st_nlink) > 1:
        raise OSError(errno.EMLINK, f"it has {names} names (hard links), and only one would change: change a copy")


def why(error: OSError) -> str:
    """Return the reason why a file can't be written, for people."""
    if error.errno == errno.EROFS:
        return "its file system is read-only: write elsewhere"
    return (error.strerror or "it cannot be written").lower()


def real(path: Path) -> Path:
    """Return the file that a path leads to, through links, as far as it exists.

    Unlike `Path.resolve`, it never raises: if a link leads to itself, opening the file reports that.
    """
    return Path(os.path.realpath(path))


def _prefix(target: Path) -> str:
    """Return the beginning of all hidden names of files that may replace a file."""
    return f".{target.name}.improv-"


def _locked(name: str) -> int | None:
    """Open a file and lock it, so that other processes leave it alone. None if this system has no such locks."""
    if sys.platform == "win32":
        return None
    import fcntl

    opened = os.open(name, os.O_RDONLY)
    with suppress(OSError):  # this file system has no locks
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return opened


def _copy_attributes(new: int, target: Path) -> None:
    """Give a new file the owner, the group, the permissions, and the attributes of the file it replaces, or the usual
    permissions if there is none. Raises OSError."""
    if sys.platform == "win32":
        return
    try:
        old = target.stat()
    except FileNotFoundError:
        os.fchmod(new, _usual_mode())
        return
    own = os.fstat(new)
    if (own.st_uid, own.st_gid) != (old.st_uid, old.st_gid):
        try:
            os.fchown(new, old.st_uid, old.st_gid)
        except OSError:
            raise PermissionError(errno.EPERM, "you can't keep its owner and its group: change a copy") from None
    if sys.platform == "linux":
        with suppress(OSError):  # not every file system has them
            for name in os.listxattr(target):
                with suppress(OSError):  # some are only for the system
                    os.setxattr(new, name, os.getxattr(target, name))
    os.fchmod(new, stat.S_IMODE(old.st_mode))


def _usual_mode() -> int:
    """Return the permissions that a new file gets here."""
    mask = os.umask(0o077)  # it can only be read by setting it
    os.umask(mask)
    return 0o666 & ~mask
