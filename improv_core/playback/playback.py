"""The parent's side of stages: starts them, controls them, and presents several as one. Standard library only."""

from __future__ import annotations

import asyncio
import math
import secrets
import time
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Protocol
from urllib.parse import urlsplit

from improv_core.playback.stage_process import Gone, Heard, StageError
from improv_core.playback.start import Options, SinkName, start_stage
from improv_core.score.movement import series
from improv_core.score.score import Score, to_json
from improv_core.stage.protocol import (
    Conduct,
    Load,
    PageRequest,
    Place,
    Ready,
    Silence,
    Speed,
    ToStage,
    TransportMessage,
    Watched,
    When,
    refused_by,
)
from improv_core.stage.tickets import issue

HALT_LIMIT = 8.0
"""Seconds that a new stage may take to find the robots of a dead one and stop them."""

News = Heard | Place
"""What a listener gets: a message from a stage, its end, or new start poses of robots that were dragged."""


class RunningStage(Protocol):
    """The part of stage_process.Stage that a playback uses."""

    @property
    def ready(self) -> Ready: ...

    @property
    def alive(self) -> bool: ...

    def send(self, message: ToStage) -> None: ...

    async def close(self) -> None: ...


class Start(Protocol):
    """The type of start.start_stage."""

    async def __call__(
        self, sink: SinkName, options: Options, token: str, hear: Callable[[RunningStage, Heard], None]
    ) -> RunningStage | None: ...


def whole_beats(transport: TransportMessage) -> str:
    """The number of beats in a transport message, for people: `8`, `∞`."""
    return "∞" if transport["beats"] is None else str(math.ceil(transport["beats"]))


async def each_beat(transport: TransportMessage) -> AsyncIterator[str]:
    """`beat 3/8` as each beat starts, beginning with the current one, forever. Counts from 1, as people do."""
    # The event loop and the stage use the same clock: time.monotonic.
    loop, period, whole = asyncio.get_running_loop(), 60 / transport["tempo"], whole_beats(transport)
    zero = transport["monotonic"] - transport["beat"] * period
    while True:
        passed = max(int((loop.time() - zero) / period), 0)
        yield f"beat {passed + 1 if transport['beats'] is None else min(passed + 1, int(whole))}/{whole}"
        await asyncio.sleep(zero + (passed + 1) * period - loop.time())


class Playback:
    """Plays scores on the chosen backend: one leading stage and, if that is ROS 2, the simulator as its twin.

    `listen` gets every message from a stage, and whether that stage leads. Use it from one event loop only.
    """

    def __init__(self, options: Options, listen: Callable[[News, bool], None], start: Start = start_stage) -> None:
        self.options = options
        self._listen = listen
        self._start = start
        self._leader: RunningStage | None = None
        self._twin: RunningStage | None = None
        self._score: Score | None = None
        self._generation = 0
        self._loaded: Load | None = None  # not yet sent to the twin
        self._kept: dict[str, Speed | Silence] = {}  # also sent to new stages
        self._opening = asyncio.Lock()
        self._stops = 0  # how often robots or everything had to stop
        self._reviving: set[asyncio.Task[None]] = set()
        self._halting: RunningStage | None = None  # a new stage that still has to stop the robots of a dead one
        self._still = asyncio.Event()
        self._waits_for: Sequence[str] = ()  # what the stage that leads says has to change
        self._failed: RunningStage | None = None  # said in its last message that it could not stop all robots
        self._token = secrets.token_urlsafe()
        self._port = options.port
        self.muted: frozenset[str] = frozenset()
        self.soloed: frozenset[str] = frozenset()
        self.watched = asyncio.Event()
        """Set as soon as somebody opens the page."""

    @property
    def status(self) -> str:
        """What it plays on, in words."""
        if not self._leader:
            return "nothing"
        about = str(self._leader.ready["sink"])
        return f"{about}, with the simulator alongside" if self._twin else about

    @property
    def page(self) -> str | None:
        """The address of the simulator's page."""
        for stage in (self._twin, self._leader):
            if stage and "page" in stage.ready:
                return str(stage.ready["page"])
        return None

    def link(self, *, own: bool = False) -> str | None:
        """A new URL that opens the page once.

        One that a browser is started with is to be this user's `own`, since others can see it in the list of processes.
        """
        return f"{self.page}?ticket={issue(self._token, own=own)}" if self.page else None

    async def open(self) -> None:
        """Start the stages unless they are running. Raises StageError."""
        async with self._opening:
            if self._leader and self._leader.alive and (not self._twin or self._twin.alive):
                return
            await self._close()
            backend = self.options.backend
            sinks: list[SinkName] = ["ros"] if backend != "sim" else []
            if backend != "ros":
                sinks.append("simulator")
            starting = [asyncio.create_task(self._start_stage(sink)) for sink in sinks]
            try:
                # Wait for both even if one fails, so that no stage is left running unnoticed.
                await asyncio.wait(starting)
                stages = [stage for each in starting if (stage := each.result())]
            except BaseException:
                await _close_all(starting)
                raise
            self._leader, self._twin = stages[0], stages[1] if len(stages) > 1 else None

    async def play(self, score: Score, when: When = "restart") -> int | None:
        """Play a score: `restart`, or take over `now`, at the next `beat`, or at the `end`. Raises StageError.

        Returns its generation; None if robots or everything had to stop before the stages were started, or if an
        emergency stop is on.
        """
        stops = self._stops
        await self.open()
        if self._stops != stops:
            return None
        if (stop := score.safety.stop) and stop in self._waits_for:
            self._listen({"type": "error", "message": refused_by(stop)}, True)
            return None
        self._score = score
        self._send_score(when)
        return self._generation

    def conduct(self, message: Conduct) -> None:
        """Send a command to all stages, effective at the same time."""
        if message["type"] == "hush":
            self._stops += 1
        elif message["type"] == "speed" or message["type"] == "silence":
            self._kept[message["type"]] = message
        elif message["type"] == "seek" and not self._score:
            line = "nothing has been played yet: save a program before you seek"
            self._listen({"type": "warning", "message": line}, True)
            return
        timed = message.copy()
        timed["at"] = time.monotonic()
        for stage in (self._leader, self._twin):
            if stage:
                stage.send(timed)

    def silence(self, muted: Iterable[str], soloed: Iterable[str]) -> None:
        """Have the muted robots, or all except the soloed ones, stand still, now and in later scores."""
        self.muted, self.soloed = frozenset(muted), frozenset(soloed)
        self.conduct({"type": "silence", "muted": sorted(self.muted), "soloed": sorted(self.soloed)})

    def keep_as(self, other: Playback) -> None:
        """Take over the speed, the muted and soloed robots, and the open pages of another playback."""
        self._kept, self.muted, self.soloed = dict(other._kept), other.muted, other.soloed
        self._token = other._token

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._stops += 1
        await asyncio.gather(*self._reviving)
        async with self._opening:
            await self._close()

    async def _close(self) -> None:
        await asyncio.gather(*(stage.close() for stage in (self._leader, self._twin) if stage))
        self._leader = self._twin = None

    async def _start_stage(self, sink: SinkName) -> RunningStage | None:
        stage = await self._start(sink, replace(self.options, port=self._port), self._token, self._hear)
        if stage:
            if "page" in stage.ready:
                # Reuse the port, so a restarted stage serves the pages that are already open.
                self._port = urlsplit(stage.ready["page"]).port or 0
            for message in self._kept.values():
                stage.send(message)
        return stage

    def _send_score(self, when: When) -> None:
        assert self._leader
        assert self._score
        self._generation += 1
        self._halting = None
        self._still.set()
        self._loaded = self._load(self._score, when)
        self._leader.send(self._loaded)

    def _load(self, score: Score, when: When) -> Load:
        data = to_json(score)
        return {"type": "load", "generation": self._generation, "score": data, "when": when, "backend": self.status}

    def _hear(self, stage: RunningStage, message: Heard) -> None:
        leads = stage is self._leader
        if message["type"] == "request":
            self._obey(message["command"])
            return
        if message["type"] == "gone":
            message = self._revive(stage, message)
        elif message["type"] == "transport" and leads:
            self._lead(message)
        elif message["type"] == "stopped" and "message" in message:
            self._failed = stage
        self._listen(message, leads)

    def _obey(self, request: PageRequest | Watched) -> None:
        """Carry out a request from the page. It goes to all stages from here, so they never disagree."""
        if request["type"] == "watched":
            self.watched.set()
        elif request["type"] == "restart":
            if self._leader and self._score:
                self._send_score("restart")
        elif request["type"] == "silence":
            self.silence(request["muted"], request["soloed"])
        elif request["type"] == "place":
            self._listen(request, True)
        else:
            self.conduct(request)

    def _lead(self, transport: TransportMessage) -> None:
        """Start the twin at exactly the same time as the leading stage, and stop and pause it when that one does."""
        waited, self._waits_for = self._waits_for, transport.get("waits_for", ())
        if transport["state"] in ("stopped", "ended"):
            self._halting = None
            self._still.set()
        if not self._twin:
            return
        loaded = self._loaded
        if transport["state"] == "playing" and loaded and transport["generation"] == loaded["generation"]:
            zero = transport["monotonic"] - transport["beat"] * 60 / transport["tempo"]
            self._twin.send({**loaded, "zero": zero})
            self._loaded = None
        elif transport["state"] == "stopped":
            self._twin.send({"type": "hush"})
        elif transport["state"] == "paused" and self._waits_for:
            self._twin.send({"type": "pause", "at": transport["monotonic"]})
        elif transport["state"] == "playing" and waited:
            self._twin.send({"type": "resume", "at": transport["monotonic"]})

    def _revive(self, dead: RunningStage, gone: Gone) -> Gone:
        """Replace a stage that has died, and return the line that says so.

        A new leading stage first stops the robots, even if a standby should have: that one may have failed too.
        """
        leads = dead is self._leader
        if leads and self._twin:
            self._twin.send({"type": "hush"})
        self._loaded = None
        if leads:
            self._waits_for = ()
        if dead is self._halting:  # another one would fail too
            self._halting = None
            self._still.set()
            return {**gone, "message": f"{gone['message']}: robots may still be moving; save to play again"}
        task = asyncio.create_task(self._replace(dead))
        self._reviving.add(task)
        task.add_done_callback(self._reviving.discard)
        if not leads:
            what = "a new one will show the next dance"
        elif dead.ready["real"] and self.options.standby and dead is not self._failed:
            what = "its robots were stopped; save to play again"
        else:
            what = "a new one is stopping the robots; save to play again"
        return {**gone, "message": f"{gone['message']}: {what}"}

    async def _replace(self, dead: RunningStage) -> None:
        async with self._opening:
            leads = dead is self._leader
            if not leads and dead is not self._twin:
                return
            try:
                new = await self._start_stage("simulator" if "page" in dead.ready else "ros")
            except StageError as error:
                self._listen({"type": "error", "message": f"no new stage could be started: {error}"}, leads)
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
    """The same robots with nothing to play, so they are only told to stop."""
    parts = {name: replace(part, movement=series(()), reset=None) for name, part in score.parts.items()}
    return Score(score.tempo, parts, world=score.world)


async def _close_all(starting: Iterable[asyncio.Task[RunningStage | None]]) -> None:
    """Close the stages that have started and cancel those that have not."""
    for each in starting:
        each.cancel()
    for stage in await asyncio.gather(*starting, return_exceptions=True):
        if stage and not isinstance(stage, BaseException):
            await stage.close()
