"""Decides if a save plays after a stop, by the state of the file at the stop, since clocks of files and machines
differ."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from enum import Enum, auto
from pathlib import Path
from typing import NamedTuple

from improv_core.program.files import ReadError, read_bytes
from improv_core.safety.stops import Stops
from improv_core.storage.atomic_write import real

LOCAL = frozenset(
    (
        *("bcachefs", "btrfs", "ecryptfs", "exfat", "ext2", "ext3", "ext4", "f2fs"),
        *("fuseblk", "hfsplus", "jfs", "msdos", "ntfs", "ntfs3", "overlay", "ramfs"),
        *("reiserfs", "squashfs", "tmpfs", "vfat", "xfs", "zfs"),
    )
)
"""Types of file systems on which everybody sees a save at once."""


class Seen(NamedTuple):
    """State of a program's file: its inode, size, times of change in ns, and contents. None: missing."""

    stamp: tuple[int, int, int, int] | None
    contents: bytes | None


class Verdict(Enum):
    PLAY = auto()
    DROP = auto()  # it was saved before the stop
    SAVE_AGAIN = auto()  # nobody knows
    ONLY_ROBOTS = auto()  # the program was not saved


def decide(handled: Seen, at_stop: Seen | None, now: Seen, *, shared: bool, told: bool = False) -> Verdict:
    """Decide what happens to a program if it or its robots have changed.

    `handled` is its state when it was played or refused last, and `at_stop` its state at the latest stop since it was
    played. On a shared drive, a save from before a stop may show only after it. After one stop, nobody is asked twice
    to save again: `told` means that a person has been asked since then.
    """
    if at_stop is None:
        return Verdict.PLAY
    if now == handled:
        return Verdict.ONLY_ROBOTS
    if told:
        return Verdict.PLAY
    if now == at_stop:
        return Verdict.DROP
    # A file that was not yet handled at the stop may have been half written then.
    return Verdict.SAVE_AGAIN if shared or at_stop != handled else Verdict.PLAY


def look(path: Path) -> Seen:
    """Read the state of a program's file now."""
    stamp = contents = None
    with contextlib.suppress(OSError, ValueError):
        found = path.stat()
        stamp = (found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns)
    with contextlib.suppress(ReadError):
        contents = read_bytes(path)
    return Seen(stamp, contents)


class StopWitness:
    """Looks at a program at each stop, on a thread: a drive that hangs must not hold up the stop."""

    def __init__(self, stops: Stops, path: Path) -> None:
        self._stops = stops
        self._path = path
        self._changed = threading.Condition()
        self._number, self._seen = -1, Seen(None, None)
        stops.on_stop(self._look_soon)
        self._look()

    async def since(self, stopped: int) -> Seen | None:
        """Return the state of the program at the latest stop; None if there has been no stop since the count was
        `stopped`."""
        if self._stops.stopped == stopped:
            return None
        return await asyncio.to_thread(self._wait)

    def _look_soon(self) -> None:
        try:
            threading.Thread(target=self._look, daemon=True).start()
        except RuntimeError:  # there can't be more threads now
            self._look()

    def _look(self) -> None:
        number = self._stops.stopped
        seen = look(self._path)
        with self._changed:
            if number > self._number:
                self._number, self._seen = number, seen
            self._changed.notify_all()

    def _wait(self) -> Seen:
        with self._changed:
            self._changed.wait_for(lambda: self._number >= self._stops.stopped)
            return self._seen


def is_shared(path: Path, mounts: Path = Path("/proc/self/mountinfo")) -> bool:
    """Return whether a file is on a drive that other machines write, or on one of an unknown kind. Only Linux reports
    that."""
    try:
        lines = mounts.read_text(errors="surrogateescape").splitlines()
    except OSError:
        return False
    found, kind = Path("/"), ""
    whole = real(path)
    for line in lines:
        before, _, after = line.partition(" - ")
        place = Path(before.split()[4].replace("\\040", " "))
        if whole.is_relative_to(place) and len(place.parts) >= len(found.parts):
            found, kind = place, after.split()[0]
    return kind not in LOCAL
