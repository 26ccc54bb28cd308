"""The stage's side of the process that reads sensors (see reader.py)."""

from __future__ import annotations

import json
import math
import os
import select
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict

from improv_core.plain import message as in_plain_text
from improv_core.score.senses import RobotSense, Topic
from improv_core.stage.protocol import FOLDER, FromReader, SenseToRead, ToReader
from improv_core.stage.sinks import Edge

START_LIMIT = 10.0
"""Seconds until a new process must show signs of life; on a quiet machine it takes half a second."""
ALIVE_LIMIT = 1.0
"""Seconds without a sign of life after which the process counts as hung."""
FIND_LIMIT = 5.0
"""Seconds that beat 0 waits for senses that are still silent, from when they were first asked for."""
AGAIN = 1.0
"""Seconds until a process that has failed is replaced: one that fails at once must not take all of the machine."""
WAIT = 0.1
"""Seconds to wait at a time."""
END_LIMIT = 2.0
"""Seconds it may take to exit."""


class Reader:
    """Has senses read by another process, which starts with the first one, and hands on edges on a thread of its own.

    If that process fails, all senses are silent until the next one hears something.
    """

    def __init__(self, node: str, hear: Callable[[Edge], None], clock: Callable[[], float]) -> None:
        self._node = node
        self._hear = hear
        self._clock = clock
        self.problem: str | None = None
        """What is wrong with the process, in one line."""
        self.unread: dict[str, str] = {}
        """Topics that can't be read, and why."""
        self._sources: Mapping[RobotSense, Topic] = {}
        self._asked = -math.inf  # when the latest sense was asked for
        self._values: dict[RobotSense, bool | None] = {}
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def read(self, sources: Mapping[RobotSense, Topic]) -> None:
        """From now on, read these senses and no others."""
        if sources.items() - self._sources.items():
            self._asked = self._clock()
        self._sources = dict(sources)
        if sources and not self._thread.ident:
            self._thread.start()

    def under_way(self) -> bool:
        """Whether a sense that was asked for lately is still silent."""
        return self._clock() < self._asked + FIND_LIMIT and any(map(self.is_silent, self._sources))

    def is_silent(self, sense: RobotSense) -> bool:
        """Whether nothing is known of a sense."""
        return self._values.get(sense) is None

    def close(self) -> None:
        """End the process."""
        self._closing.set()
        if self._thread.ident:
            self._thread.join(END_LIMIT)

    def _run(self) -> None:
        """Keep a process that reads, until we are closed."""
        while not self._closing.is_set():
            try:
                process = _start(self._node)
            except OSError as error:
                what = f"can't start: {error}"
            else:
                what = self._listen(process)
                if self._closing.is_set():
                    process.communicate()
                    return
                process.kill()
                process.wait()
            self._fall_silent()
            self.problem = f"the process that reads sensors {what}: another one starts"
            self._closing.wait(AGAIN)

    def _listen(self, process: subprocess.Popen[bytes]) -> str:
        """Hand on edges until we are closed, or the process ends or hangs; which of them, in words."""
        assert process.stdin
        assert process.stdout
        asked, unsent, rest = None, b"", b""
        waited, limit = 0.0, START_LIMIT
        poll = select.poll()
        poll.register(process.stdout, select.POLLIN)
        while not self._closing.is_set():
            if asked is not self._sources:
                asked, self.unread = self._sources, {}
                unsent += _request(asked)
            with suppress(OSError):  # it is full, or the process has ended, which is seen below
                unsent = unsent[os.write(process.stdin.fileno(), unsent) :]
            if not poll.poll(WAIT * 1000):
                waited += WAIT  # not by a clock, so that nothing is said against it while we ourselves stand still
                if waited >= limit:
                    return f"was silent for {limit} s"
                continue
            data = os.read(process.stdout.fileno(), 65_536)
            if not data:
                return "has ended"
            waited, limit, self.problem = 0.0, ALIVE_LIMIT, None
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                self._take(json.loads(line))
        return "is not needed"

    def _take(self, message: FromReader) -> None:
        if message["type"] == "edge":
            self._turn(RobotSense(message["robot"], message["sense"]), message["value"], message["at"])
        elif message["type"] == "unread":
            self.unread[message["topic"]] = in_plain_text(" ".join(message["message"].split()))

    def _turn(self, sense: RobotSense, value: bool | None, at: float) -> None:
        if self._values.get(sense) != value:
            self._values[sense] = value
            self._hear(Edge(sense, value, at))

    def _fall_silent(self) -> None:
        now = self._clock()
        for sense in list(self._values):
            self._turn(sense, None, now)


def _request(sources: Mapping[RobotSense, Topic]) -> bytes:
    senses: list[SenseToRead] = [
        {"robot": robot, "sense": sense, "source": asdict(source)} for (robot, sense), source in sources.items()
    ]
    request: ToReader = {"type": "read", "senses": senses}
    return json.dumps(request).encode() + b"\n"


def _start(node: str) -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        [sys.executable, str(FOLDER / "reader.py"), node],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert process.stdin
    os.set_blocking(process.stdin.fileno(), False)
    return process
