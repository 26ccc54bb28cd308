"""Processes that are not our children: find them, and wait for their ends (Linux)."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO


class Descriptor(int):
    """A descriptor that is closed once nothing refers to it anymore."""

    def __del__(self) -> None:
        os.close(self)


def descendants(pid: int) -> dict[int, int]:
    """Return all processes below this one, each with a descriptor that stays its own after its number is used again.
    Those of a browser are left out: all tests of a worker share it, and it starts new ones at any time."""
    found: dict[int, int] = {}
    for child in children(pid):
        if b"playwright/driver" in command_of(child):
            continue
        with suppress(ProcessLookupError, FileNotFoundError):  # it has ended meanwhile
            found[child] = Descriptor(os.pidfd_open(child))
            found.update(descendants(child))
    return found


def children(pid: int) -> Iterator[int]:
    """Yield the processes that any thread of this one has started."""
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(ProcessLookupError, FileNotFoundError):  # the thread has ended meanwhile
            yield from map(int, task.read_text().split())


def players(pid: int) -> dict[int, int]:
    """Return all processes below a language server that play, not those that check programs."""
    return {child: fd for child, fd in descendants(pid).items() if b"improv_ls." not in command_of(child)}


def ours(words: str) -> dict[int, int]:
    """Return all processes below this one whose commands contain these words."""
    return {child: fd for child, fd in descendants(os.getpid()).items() if words in command_of(child).decode()}


def command_of(pid: int) -> bytes:
    """Return the words with which a process was started, each with a zero byte at its end."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:  # it has ended meanwhile
        return b""


def stat_of(pid: int) -> list[str]:
    """Return the fields of a process after its name, from its state on (proc_pid_stat(5)). Raises OSError if it has
    ended."""
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()


def lines_until(part: str, stream: IO[str] | None) -> list[str]:
    """Return the lines of a process, up to a line with this in it, which is the last. Raises AssertionError if it ends
    before."""
    assert stream
    said: list[str] = []
    for line in stream:
        said.append(line)
        if part in line:
            return said
    raise AssertionError(f"it ended without {part!r}: {said}")


def halt(pid: int) -> None:
    """Halt a process, and wait until all its threads stand: on a busy machine, some run for a while longer."""
    os.kill(pid, signal.SIGSTOP)
    halted = False
    while not halted:
        with suppress(OSError):  # a thread has ended meanwhile
            halted = all(stat_of(int(thread.name))[0] == "T" for thread in Path(f"/proc/{pid}/task").iterdir())


def wait_until_gone(processes: dict[int, int], limit: float) -> None:
    """Wait until all have ended. Raises AssertionError if one still runs after `limit` seconds."""
    end = time.monotonic() + limit
    for pid, descriptor in processes.items():
        poll = select.poll()
        poll.register(descriptor, select.POLLIN)
        ended = poll.poll(max(end - time.monotonic(), 0) * 1000)
        assert ended, f"process {pid} still runs after {limit} s: {command_of(pid)!r}"


def in_session(leader: int) -> list[int]:
    """Return all processes of a session, whose parents may have ended."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has ended meanwhile
            if int(stat_of(int(process.name))[3]) == leader:
                found.append(int(process.name))
    return found


def wait_until_full(pid: int, limit: float) -> None:
    """Wait until no more can be written to the pipe that is a process's standard output."""
    end = time.monotonic() + limit
    pipe = os.open(f"/proc/{pid}/fd/1", os.O_WRONLY | os.O_NONBLOCK)
    poll = select.poll()
    poll.register(pipe, select.POLLOUT)
    while poll.poll(0):
        assert time.monotonic() < end, f"process {pid} could write all that it had to say within {limit} s"
        time.sleep(0.001)  # the system does not report that a pipe is full
    os.close(pipe)


def wait_until_written(process: subprocess.Popen[str], folder: Path, limit: float) -> None:
    """Wait until a process has written into a file that it has open in a folder, also one that has no name yet."""
    end = time.monotonic() + limit
    while not any(_has_written(file, folder) for file in Path(f"/proc/{process.pid}/fd").iterdir()):
        assert process.poll() is None
        assert time.monotonic() < end, f"process {process.pid} has written nothing into {folder} within {limit} s"
        time.sleep(0.01)  # nothing tells of a file without a name


def _has_written(file: Path, folder: Path) -> bool:
    """Return whether an open file of a process is in a folder, open for writing, and not empty; it may be closed
    meanwhile."""
    try:
        about = (file.parent.parent / "fdinfo" / file.name).read_text("ascii")
        is_written = int(about.partition("flags:")[2].split()[0], 8) & os.O_ACCMODE != os.O_RDONLY
        return is_written and file.readlink().is_relative_to(folder) and file.stat().st_size > 0
    except FileNotFoundError:
        return False
