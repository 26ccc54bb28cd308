"""A child process: start it, exchange lines with it, and end it. Standard library only.

`protocol/json_lines.py` is the other side: how such a process reads and writes.
"""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

MAX_READ = 65_536
"""The most bytes of one read: as many as a usual pipe holds."""
ROOT = Path(sys.executable).anchor
"""The folder in which children start: it contains no modules, and only administrators can add some."""
KILL_LIMIT = 5.0
"""Seconds that a killed process may take until it is gone."""
KILLED = -9
"""The exit code of a process that got SIGKILL, which Windows doesn't have."""
MAX_ERRORS = 50
"""The lines of standard error that are kept."""
ERRORS_LIMIT = 0.5
"""Seconds to wait for the end of standard error of a process that has exited: its own children may hold it open."""


@dataclass(frozen=True, slots=True)
class Policy:
    """The settings that differ between kinds of children."""

    end: float
    """Seconds that it may take to exit, once its input or its output has ended. Then it is killed."""
    leads: bool = False
    """True if it has a session of its own. Then Ctrl-Z in a terminal doesn't suspend it, and a kill of our process
    doesn't kill it. To kill it kills all that it has started, except processes that lead a session, too."""
    waits: bool = True
    """True if writing waits until the process reads. Otherwise, what doesn't fit into the pipe is written later."""
    errors: int = subprocess.DEVNULL
    """The target of its standard error, as for `subprocess`. With PIPE, its last line is kept."""
    pipe_size: int = 0
    """The bytes that may wait in each pipe, on systems that allow a choice; 0 for the usual number."""


class Child:
    """A process, and the lines to and from it.

    One thread may write (`write`, `close_input`) while one reads (`read`, `wait`), and any may kill it.
    """

    def __init__(
        self, command: Sequence[str], policy: Policy, env: Mapping[str, str] = os.environ, pass_fds: Sequence[int] = ()
    ) -> None:
        """Start it, `isolated`. Raises OSError."""
        self._policy = policy
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=policy.errors,
            env=isolated(env),
            cwd=ROOT,
            pass_fds=pass_fds,
            start_new_session=policy.leads,
        )
        assert self._process.stdin
        assert self._process.stdout
        self._input, self._output = self._process.stdin, self._process.stdout
        self._unsent = self._unread = b""
        self.errors: deque[str] = deque(maxlen=MAX_ERRORS)
        """The last lines on its standard error, if they are kept; complete once `wait` has returned, and empty then if
        somebody else has killed it: nothing that it wrote before is the reason."""
        if not policy.waits:
            os.set_blocking(self._input.fileno(), False)
        if policy.pipe_size:
            _widen(policy.pipe_size, self._input.fileno(), self._output.fileno())
        self._errors = threading.Thread(target=self._read_errors, daemon=True)
        if self._process.stderr:
            self._errors.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def last_error(self) -> str:
        """The last line on its standard error, if that is kept."""
        return self.errors[-1] if self.errors else ""

    def write(self, line: bytes = b"") -> None:
        """Send it a line, after those that could not be sent before. Raises OSError if it has ended and writing waits;
        otherwise `read` raises."""
        self._unsent += line
        try:
            while self._unsent:
                self._unsent = self._unsent[os.write(self._input.fileno(), self._unsent) :]
        except OSError:  # the pipe is full, or the process has ended
            if self._policy.waits:
                raise

    def write_now(self, line: bytes) -> bytes:
        """Send as much of a line as the pipe has room for, and return the rest. Not on Windows."""
        poll = select.poll()
        poll.register(self._input, select.POLLOUT)
        with suppress(OSError):  # it has ended
            while line and poll.poll(0) == [(self._input.fileno(), select.POLLOUT)]:
                line = line[os.write(self._input.fileno(), line[: select.PIPE_BUF]) :]
        return line

    def read(self, limit: float | None = None) -> list[bytes]:
        """Return the next lines, without their ends, as soon as there are some; none after `limit` seconds. Raises
        EOFError once it can send nothing more; half a line before that doesn't count. On Windows, only None can be the
        limit."""
        end = time.monotonic() + (limit or 0.0)
        lines: list[bytes] = []
        while not lines:
            data = self.read_some(limit if limit is None else end - time.monotonic())
            if not data:
                return []
            *lines, self._unread = (self._unread + data).split(b"\n")
        return lines

    def read_some(self, limit: float | None = None) -> bytes:
        """Return the next bytes, even of half a line, as `read` does: for a process that may never end its lines."""
        if self._output.closed:
            raise EOFError
        if limit is not None and not self.speaks(limit):
            return b""
        data = os.read(self._output.fileno(), MAX_READ)
        if not data:
            raise EOFError
        return data

    def speaks(self, limit: float) -> bool:
        """Wait until it sends something or can send nothing more. Returns whether that took at most `limit` seconds."""
        if not self._policy.waits:
            self.write()
        poll = select.poll()
        poll.register(self._output, select.POLLIN)
        return bool(poll.poll(max(0.0, limit) * 1000))

    def ask(self, line: bytes, limit: float) -> bytes:
        """Send a line, and return the one that answers it. If that takes more than `limit` seconds, the process counts
        as hung and is killed. Raises OSError or EOFError once it has ended. Only if writing waits."""
        patience = threading.Timer(limit, self.kill)
        patience.daemon = True
        patience.start()
        try:
            self.write(line + b"\n")
            return self.read()[0]
        finally:
            patience.cancel()

    def close_input(self) -> None:
        """Ask it to end: every child of ours does when its input has ended."""
        self._unsent = b""
        with suppress(OSError):
            self._input.close()

    def wait(self) -> int | None:
        """Close its output, and wait until it has exited, or kill it if it takes too long. Returns its exit code; None
        if even a kill has not ended it."""
        self._output.close()
        for is_killed, limit in ((False, self._policy.end), (True, KILL_LIMIT)):
            with suppress(subprocess.TimeoutExpired):
                code = self._process.wait(limit)
                if self._process.stderr:
                    self._errors.join(ERRORS_LIMIT)
                if code == KILLED and not is_killed:
                    self.errors.clear()
                return code
            self.kill()
        return None

    def end(self) -> int | None:
        """Ask it to end, and wait until it has, ignoring its output, or kill it if it takes too long. Returns as `wait`
        does. Only for a thread that both reads and writes, and not on Windows."""
        self.close_input()
        end = time.monotonic() + self._policy.end
        try:
            while (left := end - time.monotonic()) > 0:
                self.read(left)
            self.kill()
        except EOFError:
            pass
        return self.wait()

    def kill(self) -> None:
        """Kill the process if it still runs and, if it leads, all that it has started, which may be why it hangs."""
        if sys.platform == "win32" or not self._policy.leads:
            self._process.kill()
        elif self._process.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)

    def _read_errors(self) -> None:
        assert self._process.stderr
        with self._process.stderr as lines:
            for line in lines:
                self.errors.append(line.decode(errors="replace").strip())


def output(command: Sequence[str], limit: float, env: Mapping[str, str] = os.environ) -> bytes:
    """Return the standard output of a program that runs `isolated`. Raises OSError if it fails or takes longer than
    `limit` seconds; its text is the reason, in a few words."""
    nothing = subprocess.DEVNULL
    try:
        return subprocess.run(
            command, stdin=nothing, capture_output=True, timeout=limit, check=True, env=isolated(env), cwd=ROOT
        ).stdout
    except subprocess.TimeoutExpired:
        raise OSError("it took too long") from None
    except subprocess.CalledProcessError as error:
        lines = error.stderr.decode(errors="replace").strip().splitlines()
        crash = signal.strsignal(-error.returncode) if error.returncode < 0 else None  # such as "Bus error"
        raise OSError(lines[-1] if lines else crash or "no error message") from None
    except OSError as error:
        raise OSError((error.strerror or "it cannot be started").lower()) from None


def isolated(env: Mapping[str, str]) -> dict[str, str]:
    """Return this environment without the entries of PYTHONPATH that are empty or relative. In the root folder, a
    Python then imports nothing from the folder in which we were started.

    Python's option `-I` ignores all of PYTHONPATH, but without its other entries Python can't find a sourced ROS.
    """
    absolute = [entry for entry in env.get("PYTHONPATH", "").split(os.pathsep) if Path(entry).is_absolute()]
    others = {name: value for name, value in env.items() if name != "PYTHONPATH"}
    return others | ({"PYTHONPATH": os.pathsep.join(absolute)} if absolute else {})


def _widen(size: int, *pipes: int) -> None:
    with suppress(ImportError, AttributeError, OSError):  # not Linux
        import fcntl

        for pipe in pipes:
            fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, size)
