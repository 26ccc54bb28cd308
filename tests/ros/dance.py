"""A dance from its player to a subscriber, and checks for a fault in the middle of it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from improv_ls.live import TRANSPORT
from tests.ls.client import TOLD, ProcessClient
from tests.processes import descendants, lines_until, players, wait_until_gone
from tests.ros.conftest import LIMIT, Listener

URI = "file:///dance.improv"
OPTIONS = {"backend": "ros", "page": {"open": False}}
BEFORE, AFTER = "turtle1 $ repeat forward\n", "beat 90\nturtle1 $ repeat forward\n"
"""Two endless dances that differ in speed: `BEFORE_SPEED` and `AFTER_SPEED`, in m/s."""
BEFORE_SPEED, AFTER_SPEED = 2, 3
ENDED = "the stage exited unexpectedly: a new one is stopping the robots; play again"


class Conductor(Protocol):
    """A process that plays saved programs: a server or `improv watch`."""

    pid: int

    def save(self, program: str) -> None: ...

    def wait_for_line(self, part: str) -> str: ...

    def complaints(self) -> list[str]:
        """Return the warnings and errors since the last call, except those that the test has waited for."""


class Server:
    """A server whose client is in this process."""

    def __init__(
        self,
        env: Mapping[str, str],
        capabilities: Mapping[str, Any] = TOLD,
        *,
        standby: bool = True,
        uri: str = URI,
        backend: str = "ros",
    ) -> None:
        self.client = ProcessClient({**OPTIONS, "backend": backend, "ros": {"standby": standby}}, capabilities, env)
        self.pid = self.client.process.pid
        self._version = 0
        self.uri = uri
        self.client.open(uri, "")

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *failure: object) -> None:
        ours = descendants(self.pid)
        self.client.__exit__(*failure)
        wait_until_gone(ours, LIMIT)

    def type(self, program: str) -> None:
        self._version += 1
        self.client.change(self.uri, self._version, {"text": program})

    def save(self, program: str) -> None:
        self.type(program)
        self.client.save(self.uri)
        self.client.wait_for_line("▶")

    def save_until_it_plays(self, program: str) -> None:
        """Save, and again as a person would, while that counts as older than the latest stop."""
        plays = False
        while not plays:
            kept = [each for each in self.client.notifications if each["method"] != TRANSPORT]
            self.client.notifications[:] = kept  # what played before is no answer
            self.type(program)
            self.client.save(self.uri)
            line = self.client.wait("window/showMessage", lambda shown: shown["message"][0] in "▶■✗")["message"]
            if "▶" in line:  # otherwise it was stopped before it began
                told = self.client.wait(TRANSPORT, lambda told: told["state"] in ("playing", "stopped"))
                plays = told["state"] == "playing"

    def wait_for_line(self, part: str) -> str:
        return self.client.wait_for_line(part)

    def complaints(self) -> list[str]:
        shown = [each["params"] for each in self.client.notifications if each["method"] == "window/showMessage"]
        self.client.notifications.clear()
        return [params["message"] for params in shown if params["type"] <= 2]


class Terminal:
    """`improv play` or `improv watch` of a file."""

    def __init__(self, command: str, path: Path, env: Mapping[str, str], program: str = BEFORE) -> None:
        self._path = path
        self._said: list[str] = []
        path.write_text(program)
        # A session of its own: its process group is what Ctrl-C in a terminal reaches.
        self.process = subprocess.Popen(
            [sys.executable, "-m", "improv_core", command, str(path), "--backend", "ros"],
            env=env,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self.pid = self.process.pid

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *failure: object) -> None:
        self.process.kill()
        self.process.communicate(timeout=LIMIT)

    def end(self) -> tuple[int, str]:
        """Return its exit code and its last complaints."""
        _, rest = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, rest

    def save(self, program: str) -> None:
        self._path.write_text(program)

    def wait_for_line(self, part: str) -> str:
        """Wait for a line, and return it. All lines before it are complaints."""
        *before, line = lines_until(part, self.process.stderr)
        self._said += before
        return line

    def complaints(self) -> list[str]:
        said, self._said = self._said, []
        return said


def still(message: Mapping[str, Any]) -> bool:
    return not any(message[axis] for axis in ("x", "y", "z", "yaw"))


def moving(message: Mapping[str, Any]) -> bool:
    return not still(message)


def at_speed(speed: float) -> Callable[[Mapping[str, Any]], bool]:
    return lambda message: bool(message["x"] == speed)


def dances(conductor: Conductor, listener: Listener) -> None:
    """Start the dance, and wait until the stage must have finished its preparations."""
    conductor.save(BEFORE)
    for _ in range(4):
        listener.wait(at_speed(BEFORE_SPEED))


def survives(conductor: Conductor, listener: Listener, fault: Callable[[int], object], line: str) -> None:
    """Check a fault of the stage, whose process id it gets, or of other processes: the robot stands, one line says why,
    the next save plays, and no replaced process is left."""
    dances(conductor, listener)
    conductor.complaints()
    ours = players(conductor.pid)
    stage, standby = ours
    fault(stage)
    conductor.wait_for_line(line)
    listener.wait(still)
    listener.hear_all()
    conductor.save(AFTER)
    try:
        moves = listener.wait(moving)
    except AssertionError as failure:
        failure.add_note(f"complaints: {conductor.complaints()}")
        raise
    assert at_speed(AFTER_SPEED)(moves), "nothing has moved before"
    said = conductor.complaints()
    assert said == [], f"one line is all that is said, but {said} came, too"
    now = players(conductor.pid)
    assert len(now) == 2
    if stage not in now:
        assert standby not in now
        wait_until_gone(ours, LIMIT)
