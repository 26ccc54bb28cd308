"""Files that are replaced only while they hold the text that was read from them, as far as the system allows.

On Linux the new file and the old one change places in one step, and the old content is compared: if another program has
written in between, its text goes back. Elsewhere, the file is read again just before it is replaced.
"""

from __future__ import annotations

import codecs
import ctypes
import errno
import os
import secrets
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from datetime import datetime, timezone
from pathlib import Path

from improv_core.program.files import ENDING, read_bytes
from improv_core.storage.atomic_write import beside, real, remove_left
from improv_core.storage.history import VARIABLE, HistoryError
from improv_core.storage.history import keep as keep_in_history

WRITER_LIMIT = 1.0
"""Seconds to wait for a program that has the file open for writing, or has locked it."""
LOOK_PERIOD = 0.002
TRIES = 20
"""Times to check for a newer text while an older one is put back."""
_EXCHANGE = 2
_HERE = -100  # AT_FDCWD: paths are as seen from the current folder


def swap(path: Path, before: bytes | None, after: bytes, keep: Callable[[bytes], None] | None = None) -> bool:
    """Replace the content of a file, `before` (None: there is no file), by `after`. Return whether it was replaced.

    If not, another program has written the file, and it holds that program's text. If several have, it holds the latest
    text, and `keep` gets the others: see `kept`. Raises OSError.
    """
    target = real(path)
    keep = keep or (lambda text: kept(path, text))
    with _locked(target), beside(target) as new:
        new.file.write(after)
        new.complete()
        remove_left(target, lambda text: None if text in (before, after) else keep(text))
        if before is None:
            return new.put()
        hidden = new.named()
        try:
            if not _exchange(hidden, target):
                if target.read_bytes() != before:
                    return False
                hidden.replace(target)
                return True
        except FileNotFoundError:  # nothing can be lost
            return new.put()
        if _last(hidden) == before:
            return True
        _put_back(hidden, target, after, keep)
        return False


def swap_text(path: Path, before: str, after: str) -> bool:
    """Do the same for texts in UTF-8; a byte order mark, which is in neither, stays. Raises OSError and ReadError."""
    mark = codecs.BOM_UTF8 if read_bytes(path).startswith(codecs.BOM_UTF8) else b""
    return swap(path, mark + before.encode(), mark + after.encode())


def kept(path: Path, text: bytes) -> None:
    """Keep a text that another program wrote into a file just before a third one did: a program in the history, if that
    is on and can be written, and any other text beside the file. Raises OSError."""
    try:
        if path.suffix == ENDING and os.environ.get(VARIABLE) != "off":
            keep_in_history(str(path.absolute()), text.decode(), datetime.now(timezone.utc))
            return
    except (UnicodeDecodeError, HistoryError):
        pass
    path.with_name(f"{path.stem}.kept-{secrets.token_hex(4)}{path.suffix}").write_bytes(text)


def _put_back(temporary: Path, target: Path, own: bytes, keep: Callable[[bytes], None]) -> None:
    """Exchange both until the target has the latest text of other programs; at first, `temporary` has it."""
    placed: bytes | None = own
    for _ in range(TRIES):
        newest = _last(temporary)
        _exchange(temporary, target)
        if _last(temporary) == placed:  # nobody has written since that was put there
            break
        placed = newest
    if (rest := temporary.read_bytes()) != own:
        keep(rest)


@contextmanager
def _locked(target: Path) -> Iterator[None]:
    """Lock the file against our other processes and against programs that lock it, for at most `WRITER_LIMIT`."""
    if sys.platform == "win32" or not target.exists():
        yield
        return
    import fcntl

    end = time.monotonic() + WRITER_LIMIT
    file = target.open("rb")
    try:
        while time.monotonic() < end:
            with suppress(OSError):
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if os.path.samestat(os.fstat(file.fileno()), target.stat()):
                    break
                file.close()  # the process that had the lock has replaced the file
                file = target.open("rb")
                continue
            time.sleep(LOOK_PERIOD)
        yield
    finally:
        file.close()


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two files in one step; False if this system can't. Raises OSError."""
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None) if sys.platform == "linux" else None
    if rename is None:
        return False
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        return False
    raise OSError(number, os.strerror(number))


def _last(path: Path) -> bytes | None:
    """Read a file that nobody can open by its name, once nobody can write it anymore; None if somebody still can."""
    end = time.monotonic() + WRITER_LIMIT
    with path.open("rb") as file:
        while _is_written(file.fileno()):
            if time.monotonic() > end:
                return None
            time.sleep(LOOK_PERIOD)
        return file.read()


def _is_written(file: int) -> bool:
    """Return whether a process has this file open for writing: then Linux grants nobody else a lease to read it."""
    if sys.platform != "linux":
        return False
    import fcntl

    try:
        fcntl.fcntl(file, fcntl.F_SETSIG, signal.SIGURG)  # the usual signal of a lease would end the process
        fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_RDLCK)
        fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_UNLCK)
    except OSError as error:
        return error.errno == errno.EAGAIN
    return False
