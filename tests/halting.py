"""Runs tests while processes below them are halted at random, one at a time, as on a machine that is far too busy.

python -m tests.halting [arguments of pytest]

It finds tests, and code, that count on other processes being fast. Each halt is written to `.cache/halts.txt`, with the
time at which it ended. One rule: Improv's own processes are halted for less time than they allow each other; any
longer, and the robots would stop, as they should. A standby kills a stage that it finds halted after 0.12 s, but waits
for 1 s in tests with ROS. A test that halts a process itself may fail, because this may continue it. Linux only.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from tests.processes import children, command_of, stat_of

HALT, OWN_HALT, REST = 2.5, 0.4, 0.3
"""Seconds: the longest halt of a process, of one of Improv's, and the longest rest between two halts."""
OWN = (
    b"improv_",
    b"improv-",
    b"/bin/improv",
    b"ssh",
    b"relay.py",
    b"ros/base.py",
    b"ros/controller.py",
    b"ros/driver.py",
)
"""Parts of the commands that start Improv's processes, or what these count on: links to hosts, robots, and a sink."""
HALTS = Path(__file__).parents[1] / ".cache" / "halts.txt"


def main(arguments: list[str]) -> int:
    HALTS.parent.mkdir(exist_ok=True)
    tests = subprocess.Popen([sys.executable, "-m", "pytest", *arguments])
    with HALTS.open("w") as halts:
        while tests.poll() is None:
            if running := list(below(tests.pid)):
                pid = random.choice(running)
                command = command_of(pid)
                halt(pid, random.uniform(0, OWN_HALT if any(word in command for word in OWN) else HALT))
                print(time.strftime("%X"), pid, command.decode().replace("\0", " "), file=halts, flush=True)
            time.sleep(random.uniform(0, REST))
    return tests.returncode


def halt(pid: int, seconds: float) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGSTOP)
        time.sleep(seconds)
        os.kill(pid, signal.SIGCONT)


def below(pid: int) -> Iterator[int]:
    """Yield the processes below this one that aren't halted, also those of browsers."""
    for child in children(pid):
        yield from below(child)
        with suppress(OSError):  # it has ended meanwhile
            if stat_of(child)[0] in "RSD":
                yield child


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
