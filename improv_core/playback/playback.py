"""The parent's side of stages: starts them, conducts them, and shows several as one. Standard library only."""

from __future__ import annotations

import asyncio
import math
import os
import secrets
import sys
import time
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from urllib.parse import urlsplit

from improv_core.playback.interpreter import InterpreterError, find_ros_python
from improv_core.playback.stage_process import Message, Stage, StageError
from improv_core.score.movement import series
from improv_core.score.score import Score, to_json
from improv_core.stage.protocol import FOLDER

CONDUCTING = ("hush", "pause", "resume", "seek", "speed", "silence")
"""The messages by which somebody, at an editor or at the page, has a say in what plays."""
HALT_LIMIT = 8.0
"""Seconds a new stage may take to find the robots of one that has died, and to stop them."""


@dataclass(frozen=True, slots=True)
class Options:
    """What to play on: `backend` is auto, sim, ros or both; `ros_python` and `discovery` as in the settings.

    With `report_sent`, stages tell of every velocity they send. `takes_start_poses` is for a listener that handles
    `place` requests: only then does the page offer to write start poses into improv.toml.
    """

    backend: str = "auto"
    port: int = 0
    ros_python: str | None = None
    discovery: str | None = None
    report_sent: bool = False
    takes_start_poses: bool = False


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
        yield f"beat {passed + 1 if transport['beats'] is None else min(passed + 1, int(whole))}/{whole}"
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
        self._score: Score | None = None
        self._generation = 0
        self._loaded: Message = {}  # what the twin still has to be told
        self._kept: dict[str, Message] = {}  # speed and silence, which new stages are told too
        self._opening = asyncio.Lock()
        self._stops = 0  # how often robots were to stop, or all to end
        self._reviving: set[asyncio.Task[None]] = set()
        self._halting: Stage | None = None  # a new one that has yet to stop what another left moving
        self._still = asyncio.Event()
        self._token = secrets.token_urlsafe()
        self._port = options.port
        self.muted: frozenset[str] = frozenset()
        self.soloed: frozenset[str] = frozenset()
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

    async def play(self, score: Score, when: str = "restart") -> int | None:
        """Play a score: `restart`, or take over `now`, at the `beat` or `end`. Raises StageError.

        Its generation; None if robots were to stop, or all to end, before the stages had been started.
        """
        stops = self._stops
        await self.open()
        if self._stops != stops:
            return None
        self._score = score
        self._send_score(when)
        return self._generation

    def conduct(self, kind: str, **values: object) -> None:
        """Have all stages do one thing at one time: a message of `CONDUCTING` (docs/protocol.md)."""
        message = {"type": kind, **values, "at": time.monotonic()}
        self._stops += kind == "hush"
        if kind in ("speed", "silence"):
            self._kept[kind] = {"type": kind, **values}
        for stage in (self._leader, self._twin):
            if stage:
                stage.send(message)

    def silence(self, muted: Iterable[str], soloed: Iterable[str]) -> None:
        """Have these robots stand still, or all but the soloed ones, now and in what is played later."""
        self.muted, self.soloed = frozenset(muted), frozenset(soloed)
        self.conduct("silence", muted=sorted(self.muted), soloed=sorted(self.soloed))

    def keep_as(self, other: Playback) -> None:
        """Have the same robots stand still as in another playback, at the same speed."""
        self._kept, self.muted, self.soloed = dict(other._kept), other.muted, other.soloed

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._stops += 1
        await asyncio.gather(*self._reviving)
        async with self._opening:
            await self._close()

    async def _close(self) -> None:
        await asyncio.gather(*(stage.close() for stage in (self._leader, self._twin) if stage))
        self._leader = self._twin = None

    async def _start_simulator(self) -> Stage:
        taking = ["--takes-start-poses"] if self.options.takes_start_poses else []
        options = ["--sink", "simulator", "--port", str(self._port), *taking, *self._reporting]
        command = [sys.executable, str(FOLDER), *options]
        stage = await Stage.start(command, {**os.environ, "IMPROV_PAGE_TOKEN": self._token}, self._hear)
        # A stage that has to be started anew serves the pages that are open already.
        self._port = urlsplit(stage.ready["page"]).port or 0
        self._tell_kept(stage)
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
                "no Python with rclpy was found: run `improv ros setup`, source your ROS 2 "
                "(`source /opt/ros/…/setup.bash`), or set IMPROV_ROS_PYTHON to a Python that has it"
            )
        discovery = ["--discovery", self.options.discovery] if self.options.discovery else []
        stage = await Stage.start(
            [found.python, str(FOLDER), "--sink", "ros", *discovery, *self._reporting], found.env, self._hear
        )
        self._tell_kept(stage)
        return stage

    @property
    def _reporting(self) -> list[str]:
        return ["--report-sent"] if self.options.report_sent else []

    def _tell_kept(self, stage: Stage) -> None:
        for message in self._kept.values():
            stage.send(message)

    def _send_score(self, when: str) -> None:
        assert self._leader
        assert self._score
        self._generation += 1
        self._halting = None
        self._loaded = self._load(self._score, when)
        self._leader.send(self._loaded)

    def _load(self, score: Score, when: str) -> Message:
        data = to_json(score)
        return {"type": "load", "generation": self._generation, "score": data, "when": when, "backend": self.status}

    def _hear(self, stage: Stage, message: Message) -> None:
        leads = stage is self._leader
        kind = message["type"]
        if kind == "request":
            self._obey(message["command"])
            return
        if kind == "gone":
            message = self._revive(stage, message)
        elif kind == "transport" and leads:
            self._lead(message)
        self._listen(message, leads)

    def _obey(self, request: Message) -> None:
        """What the page asks for goes to all stages by way of here, so that there is one truth."""
        kind, values = request["type"], {name: value for name, value in request.items() if name != "type"}
        if kind == "watched":
            self.watched.set()
        elif kind == "restart" and self._leader and self._score:
            self._send_score("restart")
        elif kind == "silence":
            self.silence(values["muted"], values["soloed"])
        elif kind == "place":
            self._listen(request, True)
        elif kind in CONDUCTING:
            self.conduct(kind, **values)

    def _lead(self, transport: Message) -> None:
        """Have the twin begin at the very same time as the stage that leads, and stop when that stops by itself."""
        if transport["state"] in ("stopped", "ended"):
            self._halting = None
            self._still.set()
        if not self._twin:
            return
        if transport["state"] == "playing" and transport["generation"] == self._loaded.get("generation"):
            zero = transport["monotonic"] - transport["beat"] * 60 / transport["tempo"]
            self._twin.send({**self._loaded, "zero": zero})
            self._loaded = {}
        elif transport["state"] == "stopped":
            self._twin.send({"type": "hush"})

    def _revive(self, dead: Stage, gone: Message) -> Message:
        """Start a new stage in the place of one that has died; what leads stops the robots first. What to tell."""
        leads = dead is self._leader
        if leads and self._twin:
            self._twin.send({"type": "hush"})
        self._loaded = {}
        if dead is self._halting:  # the next one would fare no better
            self._halting = None
            self._still.set()
            return {**gone, "message": f"{gone['message']}: robots may still move; save to play again"}
        task = asyncio.create_task(self._replace(dead))
        self._reviving.add(task)
        task.add_done_callback(self._reviving.discard)
        what = "a new one stops the robots; save to play again" if leads else "a new one shows what is played next"
        return {**gone, "message": f"{gone['message']}: {what}"}

    async def _replace(self, dead: Stage) -> None:
        async with self._opening:
            leads = dead is self._leader
            if not leads and dead is not self._twin:
                return
            try:
                new = await (self._start_simulator() if "page" in dead.ready else self._start_ros())
            except StageError as error:
                self._listen({"type": "error", "message": f"no new stage can be started: {error}"}, leads)
                new = None
            if not leads:
                self._twin = new
                return
            self._leader = new
        if new and self._score:
            self._halting = new
            self._still.clear()
            new.send(self._load(_standing(self._score), "restart"))
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._still.wait(), HALT_LIMIT)


def _standing(score: Score) -> Score:
    """The same robots with nothing to play: all they are told is to stop."""
    parts = {name: replace(part, movement=series(()), reset=None) for name, part in score.parts.items()}
    return Score(score.tempo, parts, world=score.world)


async def _nothing() -> None:
    return None
