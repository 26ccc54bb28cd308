"""The parent's side of stages: starts them, feeds them, and shows several as one. Standard library only."""

from __future__ import annotations

import asyncio
import json
import math
import os
import secrets
import sys
from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from improv_core.score import Score, to_json
from improv_core.stage.interpreter import InterpreterError, find_ros_python

Message = Mapping[str, Any]

START_LIMIT = 60.0
"""Seconds a stage may take to say that it is ready, on a busy machine."""
END_LIMIT = 3.0
"""Seconds a stage may take to stop its robots and end, before it is killed."""


class StageError(Exception):
    """A stage can't be had; one plain line that says what to do."""


@dataclass(frozen=True, slots=True)
class Options:
    """What to play on: `backend` is auto, sim, ros or both; `ros_python` and `discovery` as in the settings."""

    backend: str = "auto"
    port: int = 0
    ros_python: str | None = None
    discovery: str | None = None


def whole_beats(transport: Message) -> str:
    """How many beats a transport message speaks of, for people: `8`, `∞`."""
    return "∞" if transport["beats"] is None else str(math.ceil(transport["beats"]))


async def each_beat(transport: Message) -> AsyncIterator[str]:
    """`beat 3/8` as each beat begins, from the one that plays now on, without end. Counts from 1, as people do."""
    # The loop's clock is the one the stage plays by: time.monotonic.
    loop, period, whole = asyncio.get_running_loop(), 60 / transport["tempo"], whole_beats(transport)
    zero = transport["monotonic"] - transport["beat"] * period
    while True:
        passed = max(int((loop.time() - zero) / period), 0)
        yield f"beat {passed + 1}/{whole}"
        await asyncio.sleep(zero + (passed + 1) * period - loop.time())


class Playback:
    """Plays scores on the chosen backend: one stage that leads, and where that is ROS 2, the simulator as its twin.

    `listen` gets every message of a stage, and whether that stage leads. Used from one event loop.
    """

    def __init__(self, options: Options, listen: Callable[[Message, bool], None]) -> None:
        self.options = options
        self._listen = listen
        self._leader: Stage | None = None
        self._twin: Stage | None = None
        self._generation = 0
        self._loaded: Message = {}
        self._opening = asyncio.Lock()
        self._token = secrets.token_urlsafe()
        self._port = options.port
        self.watched = asyncio.Event()
        """Set once somebody looks at the page."""

    @property
    def status(self) -> str:
        """What it plays on, in words."""
        if not self._leader:
            return "nothing"
        about = str(self._leader.ready["sink"])
        return f"{about}, the simulator beside it" if self._twin else about

    @property
    def page(self) -> str | None:
        """The URL of the simulator's page."""
        for stage in (self._twin, self._leader):
            if stage and "page" in stage.ready:
                return str(stage.ready["page"])
        return None

    async def open(self) -> None:
        """Start the stages, unless they run. Raises StageError."""
        async with self._opening:
            if self._leader and self._leader.alive and (not self._twin or self._twin.alive):
                return
            await self._close()
            backend = self.options.backend
            started = await asyncio.gather(
                self._start_ros() if backend != "sim" else _nothing(),
                self._start_simulator() if backend != "ros" else _nothing(),
                return_exceptions=True,
            )
            stages = [stage for stage in started if isinstance(stage, Stage)]
            for problem in started:
                if isinstance(problem, BaseException):
                    await asyncio.gather(*(stage.close() for stage in stages))
                    raise problem
            self._leader, self._twin = stages[0], stages[1] if len(stages) > 1 else None

    async def play(self, score: Score, when: str = "restart") -> int:
        """Play a score: `restart`, or take over `now`, at the `beat` or `end`. Its generation. Raises StageError."""
        await self.open()
        assert self._leader
        self._generation += 1
        self._loaded = {
            "type": "load",
            "generation": self._generation,
            "score": to_json(score),
            "when": when,
            "backend": self.status,
        }
        self._leader.send(self._loaded)
        return self._generation

    def hush(self) -> None:
        """Stop every robot at once."""
        for stage in (self._leader, self._twin):
            if stage:
                stage.send({"type": "hush"})

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        async with self._opening:
            await self._close()

    async def _close(self) -> None:
        stages = [stage for stage in (self._leader, self._twin) if stage]
        self._leader = self._twin = None
        await asyncio.gather(*(stage.close() for stage in stages))

    async def _start_simulator(self) -> Stage:
        command = [sys.executable, _STAGE, "--sink", "simulator", "--port", str(self._port)]
        stage = await Stage.start(command, {**os.environ, "IMPROV_PAGE_TOKEN": self._token}, self._hear)
        # A stage that has to be started anew serves the pages that are open already.
        self._port = urlsplit(stage.ready["page"]).port or 0
        return stage

    async def _start_ros(self) -> Stage | None:
        try:
            found = await asyncio.to_thread(find_ros_python, self.options.ros_python)
        except InterpreterError as error:
            raise StageError(str(error)) from None
        if not found:
            if self.options.backend == "auto":
                return None
            raise StageError(
                "no Python with rclpy was found: source your ROS 2 (`source /opt/ros/…/setup.bash`), "
                "or set IMPROV_ROS_PYTHON to one that has it"
            )
        discovery = ["--discovery", self.options.discovery] if self.options.discovery else []
        return await Stage.start([found.python, _STAGE, "--sink", "ros", *discovery], found.env, self._hear)

    def _hear(self, stage: Stage, message: Message) -> None:
        leads = stage is self._leader
        if message["type"] == "request":
            self._obey(message["command"]["type"])
            return
        if leads and self._twin and message["type"] == "transport":
            self._lead(message)
        self._listen(message, leads)

    def _obey(self, request: str) -> None:
        """What the page asks for goes to all stages by way of here, so that there is one truth."""
        if request == "hush":
            self.hush()
        elif request == "watched":
            self.watched.set()

    def _lead(self, transport: Message) -> None:
        """Have the twin begin at the very same time as the stage that leads."""
        if transport["state"] == "playing" and transport["generation"] == self._loaded.get("generation"):
            assert self._twin
            zero = transport["monotonic"] - transport["beat"] * 60 / transport["tempo"]
            self._twin.send({**self._loaded, "zero": zero})


class Stage:
    """A stage process. Made by `start`; `ready` is its first message."""

    def __init__(self, process: asyncio.subprocess.Process, hear: Callable[[Stage, Message], None]) -> None:
        self._process = process
        self._hear = hear
        self._closing = False
        self._ready: asyncio.Future[Message] = asyncio.get_running_loop().create_future()
        self._last_words: deque[str] = deque(maxlen=5)
        self._tasks = [asyncio.create_task(self._read()), asyncio.create_task(self._read_log())]

    @classmethod
    async def start(
        cls, command: Sequence[str], env: Mapping[str, str], hear: Callable[[Stage, Message], None]
    ) -> Stage:
        """Start a stage and wait until it is ready. Raises StageError with what it says is wrong."""
        pipe = asyncio.subprocess.PIPE
        try:
            process = await asyncio.create_subprocess_exec(
                *command, stdin=pipe, stdout=pipe, stderr=pipe, env=env, limit=2**24
            )
        except OSError as error:
            raise StageError(f"{command[0]} can't be started: {error.strerror}") from None
        stage = cls(process, hear)
        try:
            first = await asyncio.wait_for(asyncio.shield(stage._ready), START_LIMIT)
        except asyncio.TimeoutError:
            first = {"type": "error", "message": "the stage did not start in time: try again"}
        if first["type"] != "ready":
            await stage.close()
            raise StageError(first["message"])
        return stage

    @property
    def ready(self) -> Message:
        return self._ready.result()

    @property
    def alive(self) -> bool:
        return self._process.returncode is None and not self._closing

    def send(self, message: Message) -> None:
        """Send a message; one to a stage that has died is lost, and its end has been told."""
        assert self._process.stdin
        if not self._process.stdin.is_closing():
            self._process.stdin.write(json.dumps(message).encode() + b"\n")

    async def close(self) -> None:
        """Close its input, which stops the robots and ends it; one that does not end is killed."""
        self._closing = True
        assert self._process.stdin
        self._process.stdin.close()
        try:
            await asyncio.wait_for(self._process.wait(), END_LIMIT)
        except asyncio.TimeoutError:
            self._process.kill()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _read(self) -> None:
        assert self._process.stdout
        async for line in self._process.stdout:
            message = json.loads(line)
            if not self._ready.done():
                self._ready.set_result(message)
            elif not self._closing:
                self._hear(self, message)
        await self._process.wait()
        why = f"the stage ended: {self._last_words[-1]}" if self._last_words else "the stage ended by itself"
        gone = {"type": "gone", "message": f"{why}; save again to start it anew"}
        if not self._ready.done():
            self._ready.set_result({**gone, "message": why})
        elif not self._closing:
            self._hear(self, gone)

    async def _read_log(self) -> None:
        assert self._process.stderr
        async for line in self._process.stderr:
            self._last_words.append(line.decode(errors="replace").strip())


_STAGE = str(Path(__file__).resolve().parent)


async def _nothing() -> None:
    return None
