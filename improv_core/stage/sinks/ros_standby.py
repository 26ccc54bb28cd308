"""The stage's side of the standby process, which stops robots if the stage dies (see standby.py)."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress

from improv_core.stage.protocol import FOLDER, HANG_LIMIT, ToStandby

PULSE_PERIOD = 0.1
"""Seconds between two signs of life while robots move."""
PATIENCE = HANG_LIMIT + PULSE_PERIOD
"""Seconds without a sign of life after which the stage counts as hung. The parent comes first, since it says so."""
START_LIMIT = 5.0
"""Seconds to wait until it has started; on a quiet machine it takes half a second."""
PIPE_SIZE = 1 << 20
"""Bytes that may wait for the standby. What it is told about 1,000 robots doesn't fit into a usual pipe."""
END_LIMIT = 2.0
"""Seconds it may take to exit."""


class Standby:
    """Knows what is published where and which robots move, and sends zeros if the stage dies.

    It publishes with the same arguments of ROS (`--ros-args …`) as the stage, so that remapping holds for it too.

    Once it has started, nothing waits for it: one that doesn't read its input has failed, and `problem` says so.
    """

    def __init__(self, node: str, arguments: Sequence[str], clock: Callable[[], float], wanted: bool) -> None:
        self._command = [sys.executable, str(FOLDER / "standby.py"), node, *arguments]
        self._clock = clock
        self.problem: str | None = None
        """What is wrong with the standby, in one line."""
        self._publishers: dict[tuple[str, str], bool] = {}  # topic and kind: whether the second node has it
        self._moving: dict[str, str] = {}  # topics and the frames of velocities on them
        self._pulse = 0.0  # when the next sign of life is due
        self._found: set[str] = set()  # topics on which it has found a listener
        self._process = _start(self._command) if wanted else None

    @property
    def works(self) -> bool:
        """Whether there is one, as far as is known."""
        return self._process is not None and self.problem is None

    def wait(self) -> None:
        """Wait until it has started, which takes the processor that robots will need."""
        if self._process and self._process.stdout:
            select.select([self._process.stdout], [], [], START_LIMIT)

    def unfound(self, topics: Iterable[str]) -> set[str]:
        """The topics on which it has yet to find a listener: it can't stop robots there at once."""
        if not self._process or not self._process.stdout or self.problem:
            return set()
        with suppress(BlockingIOError):
            self._found.update(os.read(self._process.stdout.fileno(), 65_536).decode().split("\n"))
        return set(topics) - self._found

    def renew(self) -> None:
        """Start another one if it has failed."""
        if not self._process or (self._process.poll() is None and not self.problem):
            return
        self._process.kill()
        self._process.wait()
        self._process, self.problem = _start(self._command), None
        self._found.clear()
        for (topic, kind), second in self._publishers.items():
            self._tell({"type": "publish", "topic": topic, "kind": kind, "second": second})
        for topic, frame in self._moving.items():
            self._tell({"type": "moves", "topic": topic, "frame": frame, "patience": PATIENCE})

    def publish(self, topic: str, kind: str, second: bool) -> None:
        """The stage has created a publisher of a message type on a topic, on its second node or not."""
        self._publishers[topic, kind] = second
        self._found.discard(topic)  # it has another publisher to match there
        self._tell({"type": "publish", "topic": topic, "kind": kind, "second": second})

    def withdraw(self, topic: str, kind: str) -> None:
        """The stage has destroyed this publisher."""
        del self._publishers[topic, kind]
        self._tell({"type": "withdraw", "topic": topic, "kind": kind})

    def moves(self, topic: str, frame: str) -> None:
        """The robot on a topic is about to be told to move, by velocities in a frame."""
        if self._moving.get(topic) != frame:
            self._moving[topic] = frame
            self._tell({"type": "moves", "topic": topic, "frame": frame, "patience": PATIENCE})
            self._pulse = self._clock() + PULSE_PERIOD

    def stands(self, topic: str) -> None:
        """The robot on a topic has been told to stop."""
        if topic in self._moving:
            del self._moving[topic]
            if not self._moving:
                self._tell({"type": "stands"})

    def live(self, patience: float = PATIENCE) -> None:
        """A sign of life, at most once per `PULSE_PERIOD`, or at once if it needs more patience than usual."""
        now = self._clock()
        if self._moving and (now >= self._pulse or patience != PATIENCE):
            self._tell({"type": "pulse", "patience": patience})
            self._pulse = now + PULSE_PERIOD

    def close(self) -> None:
        """End the process. If robots still move because the stage could not stop them, it tries that first."""
        if not self._moving:
            self._tell({"type": "end"})
        if self._process and self._process.stdin:
            self._process.stdin.close()
            try:
                self._process.wait(END_LIMIT)
            except subprocess.TimeoutExpired:
                self._process.kill()

    def _tell(self, message: ToStandby) -> None:
        if not self.works:
            return
        assert self._process
        assert self._process.stdin
        try:
            # Lines this short are written completely or not at all, even if the pipe is full.
            os.write(self._process.stdin.fileno(), json.dumps(message).encode() + b"\n")
        except OSError as error:
            what = "has ended" if isinstance(error, BrokenPipeError) else "does not respond"
            self.problem = (
                f"the standby process {what}, so if the stage dies, robots keep moving until a new stage finds them: "
                "the next play starts another standby"
            )


def _start(command: Sequence[str]) -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    assert process.stdin
    assert process.stdout
    for stream in (process.stdin, process.stdout):
        os.set_blocking(stream.fileno(), False)
    with suppress(ImportError, AttributeError, OSError):  # not Linux
        import fcntl

        fcntl.fcntl(process.stdin, fcntl.F_SETPIPE_SZ, PIPE_SIZE)
    return process
