"""Lets only one parent play on a machine at a time, and tells the second one who plays (Unix)."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import socket
import time
from contextlib import suppress
from pathlib import Path

from improv_core.protocol.limits import END_LIMIT

AGAIN = 0.05
"""Seconds between two tries."""
UNNAMED = 1.0
"""Seconds that a parent that has just taken the machine may need to write its name."""


class TakenError(Exception):
    """Somebody else plays on this machine. The message has the name."""


def take(folder: Path, who: str) -> int:
    """Take this machine for a parent, until the returned file descriptor is closed. The same parent may take it over
    from a far end of its own to which it has lost the link: that one ends. Raises TakenError, OSError."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    # The home folder may be shared with other machines.
    lock = os.open(folder / f"taken-{socket.gethostname()}", os.O_RDWR | os.O_CREAT, 0o600)
    began, told = time.monotonic(), False
    while not _locked(lock):
        waited = time.monotonic() - began
        holder, pid = _holder(lock)
        if holder != who:
            if holder or waited > UNNAMED:
                os.close(lock)
                raise TakenError(holder.partition("/")[0] or "somebody else")
        elif waited > 2 * END_LIMIT:
            _signal(pid, signal.SIGKILL)
        elif not told:
            told = True
            _signal(pid, signal.SIGTERM)
        time.sleep(AGAIN)
    os.ftruncate(lock, 0)
    os.pwrite(lock, json.dumps([who, os.getpid()]).encode(), 0)
    return lock


def _locked(lock: int) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _holder(lock: int) -> tuple[str, int]:
    with suppress(ValueError, TypeError):
        who, pid = json.loads(os.pread(lock, 1_000, 0))
        return str(who), int(pid)
    return "", 0


def _signal(pid: int, number: int) -> None:
    if pid > 1:
        with suppress(ProcessLookupError, PermissionError):
            os.kill(pid, number)
