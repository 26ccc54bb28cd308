"""The parent's side of stages: starts them, controls them, and presents several as one. Standard library only."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import AsyncIterator, Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Protocol
from urllib.parse import urlsplit

from improv_core.playback.editions import Editions
from improv_core.playback.loads import Asked, Loads
from improv_core.playback.stage_process import Gone, Heard, StageError
from improv_core.playback.start import Options, SinkName, start_stage
from improv_core.playback.stop_socket import IDLE
from improv_core.playback.stops import KNOWN, Stops
from improv_core.score.score import Part, Score
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.stage.commands import (
    COMMANDS,
    Cue,
    Editing,
    Force,
    Form,
    Held,
    KeySense,
    PageRequest,
    PlaceRobots,
    Released,
    Seek,
    Silence,
    Speed,
    Watched,
)
from improv_core.stage.editing import Answer, ProgramSource
from improv_core.stage.messages import (
    Problem,
    ProgramMessage,
    Ready,
    Sensed,
    ToStage,
    TransportMessage,
    WarningLine,
    When,
    counted,
)
from improv_core.stage.tickets import issue

BEHIND = 0.1
"""Seconds by which the simulator plays a score with senses behind real robots: what they decide has to arrive first."""
AFTER = 0.02
"""Seconds after each beat until people are told of it: at the beat itself, the stage needs the processor."""
HALT_LIMIT = 8.0
"""Seconds that a new stage may take to find the robots of a dead one and stop them."""

MOST_MISTAKES = 20
"""The most mistakes that pages list."""

Change = Seek | Speed | Silence | Held | Released | Cue | KeySense | Force
"""What people can do to what plays, apart from stopping, pausing, and resuming it."""
Mistake = tuple[str, int, int, str, str]
"""What keeps a program from being played: the file, the line and the column from 1, the word there, and a message."""
Edit = Callable[[Editing, int], None]
"""Handles what a page asks for while somebody edits the program; also gets the count of stops at that moment."""
News = Heard | PlaceRobots | Form
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
        self,
        sink: SinkName,
        options: Options,
        token: str,
        hear: Callable[[RunningStage, Heard, int], None],
        stops: Stops,
    ) -> RunningStage | None: ...


async def each_beat(transport: TransportMessage) -> AsyncIterator[str]:
    """`beat 3/8` as each beat starts, beginning with the current one, forever."""
    # The event loop and the stage use the same clock: time.monotonic.
    loop, period = asyncio.get_running_loop(), 60 / transport["tempo"]
    zero = transport["monotonic"] - transport["beat"] * period
    while True:
        passed = max(int((loop.time() - zero) / period), 0)
        yield counted(transport, passed)
        await asyncio.sleep(zero + (passed + 1) * period + AFTER - loop.time())


class Playback:
    """Plays scores on the chosen backend: one leading stage and, if that is ROS 2, the simulator as its twin.

    `listen` gets every message from a stage, and whether that stage leads. Use it from one event loop only, except
    `stops` and `stop`. Without `edit`, no page can edit the program.
    """

    def __init__(
        self,
        options: Options,
        listen: Callable[[News, bool], None],
        stops: Stops,
        start: Start = start_stage,
        edit: Edit | None = None,
    ) -> None:
        self.options = options
        self.stops = stops
        self._listen = listen
        self._edit = edit
        self._start = start
        self._loop: asyncio.AbstractEventLoop | None = None
        self._leader: RunningStage | None = None
        self._twin: RunningStage | None = None
        self._idle: RunningStage | None = None  # of real robots, while the simulator plays alone
        self._idle_score: Score | None = None  # that its robots played last
        self._score: Score | None = None
        self._senses: Sequence[Sensed] | None = None  # of the recording that it is performed by
        self._name = ""  # of the program that plays, or is about to
        self._generation = 0
        self._editions = Editions()
        self._loads = Loads()
        self._latest: Asked | None = None
        self._behind = 0.0  # how many seconds the twin plays behind the leading stage
        self._entered: TransportMessage | None = None  # the first message of the latest score's playing
        self._kept: dict[str, Change | ProgramMessage | ProgramSource] = {}  # also sent to new stages
        self._opening = asyncio.Lock()
        self._ends = 0  # how often everything had to end
        self._reviving: set[asyncio.Task[None]] = set()
        self._halting: RunningStage | None = None  # a new stage that only has to stop the robots of a dead one
        self._still = asyncio.Event()
        self._waits_for: Sequence[str] = ()  # what has to change, according to the leading stage
        self._token = secrets.token_urlsafe()
        self._port = options.port
        self.is_on = False
        """Whether something plays, or is about to."""
        self._beginning = 0  # how many wait for the stages to start
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
    def is_real(self) -> bool:
        """Whether real robots play."""
        return self._leader is not None and self._leader.ready["real"]

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

    @property
    def _stages(self) -> list[RunningStage]:
        return [stage for stage in (self._leader, self._twin, self._idle) if stage]

    def present(self, name: str, folder: str, mistakes: Iterable[Mistake] = ()) -> None:
        """Have pages show which program is to be played, and what keeps it from being played."""
        problems: list[Problem] = [
            {"file": file, "line": line, "column": column, "word": word, "message": message}
            for file, line, column, word, message in mistakes
        ]
        shown, count = problems[:MOST_MISTAKES], len(problems)
        program: ProgramMessage = {"type": "program", "name": name, "folder": folder, "problems": shown, "count": count}
        self._kept["program"] = program
        for stage in self._stages:
            stage.send(program)

    def tell_pages(self, message: ProgramSource | Answer) -> None:
        """Tell pages what they may edit, now and when they are opened, or answer one of them."""
        if message["type"] == "source":
            self._kept["source"] = message
        for stage in self._stages:
            if "page" in stage.ready:
                stage.send(message)

    async def open(self) -> None:
        """Start the stages unless they are running. Raises StageError."""
        self._loop = asyncio.get_running_loop()
        async with self._opening:
            if self._leader and all(stage.alive for stage in self._stages):
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
                await self._close()
                raise
            self._leader, self._twin = stages[0], stages[1] if len(stages) > 1 else None
            if self.is_real and self.stops.unreachable:
                await self._close()
                raise StageError(f"real robots need `improv stop`: {self.stops.unreachable}")

    async def play(
        self,
        score: Score,
        name: str,
        asked: int,
        when: When = "restart",
        beats_per_bar: int = BEATS_PER_BAR,
        senses: Sequence[Sensed] | None = None,
        simulated: bool = False,
    ) -> int | None:
        """Play a program's score: `restart`, or take over `now`, at the next `beat` or `bar`, or at the `end`.

        Parts that are the same as in the score that plays are not touched when it takes over. If `simulated`, only the
        simulator plays it, and real robots stop.

        With `senses`, robots sense what is in this recording, and nothing else. `asked` is the count of `stops` when
        somebody asked for it. Returns its generation; None if it has been stopped
        since then, before it began, or if an emergency stop is on. Raises StageError, also if it is to be `simulated`
        and there is no simulator.
        """
        ends = self._ends
        if not self.is_on:
            self._name = name
        self._beginning += 1
        try:
            await self.open()
        finally:
            self._beginning -= 1
        if self._ends != ends:
            return None
        assert self._leader
        stage = self._idle or self._leader
        if stage.ready["real"] and not simulated and (line := self.stops.refusal(score.safety.stop)):
            stage.send(self.stops.pressed)  # another one may have heard it: this one has to hear its release
            self._listen({"type": "error", "message": line}, True)
            return None
        self._let_lead(simulated)
        self._senses = senses
        return self._generation if self._send_score(score, name, when, beats_per_bar, asked) else None

    def _let_lead(self, simulated: bool) -> None:
        """Have the simulator play alone, while the stage of real robots stops them and waits, or both play again."""
        assert self._leader
        if simulated and self._twin:
            self._leader.send({"type": "hush"})
            self._idle, self._leader, self._twin = self._leader, self._twin, None
            self._idle_score = self._score
        elif simulated and self._leader.ready["real"]:
            raise StageError("no robot is named, and there is no simulator: set improv.backend to auto, sim, or both")
        elif not simulated and self._idle:
            self._leader.send({"type": "hush"})  # its robots must not keep dancing while real ones are waited for
            self._leader, self._twin, self._idle = self._idle, self._leader, None

    def revise(self, score: Score) -> None:
        """Have a page's Restart play this score instead of the one that was played."""
        if self._score:
            self._score = score

    def resume(self, asked: int) -> None:
        """Resume all stages after a pause. `asked` is as for `play`."""
        stages = [stage for stage in (self._leader, self._twin) if stage]
        self.stops.send({"type": "resume", "at": time.monotonic()}, stages, asked)

    def conduct(self, message: Change) -> None:
        """Send a command to all stages, effective at the same time."""
        row = COMMANDS[message["type"]]
        if row.kept:
            self._kept[row.name] = message
        elif message["type"] == "seek" and not self._score:
            line = "nothing has been played yet: save a program before you seek"
            self._listen({"type": "warning", "message": line}, True)
            return
        timed = message.copy()
        timed["at"] = time.monotonic()
        if self._leader:
            self._leader.send(timed)
        if self._idle and row.kept:
            self._idle.send(timed)  # it holds for what it plays next
        if not self._twin or row.as_sensed:
            return
        if not self._behind:
            self._twin.send(timed)
            return
        later = timed.copy()
        later["at"] += self._behind
        asyncio.get_running_loop().call_later(self._behind, self._twin.send, later)

    def silence(self, muted: Iterable[str], soloed: Iterable[str]) -> None:
        """Have the muted robots, or all except the soloed ones, stand still, now and in later scores."""
        self.muted, self.soloed = frozenset(muted), frozenset(soloed)
        self.conduct({"type": "silence", "muted": sorted(self.muted), "soloed": sorted(self.soloed)})

    def keep_as(self, other: Playback) -> None:
        """Take over the speed, the muted and soloed robots, and the open pages of another playback.

        Dances are counted from its count on, so none here has the number of one there that may still be ending.
        """
        self._kept, self.muted, self.soloed = dict(other._kept), other.muted, other.soloed
        self._token, self._generation = other._token, other._generation

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._ends += 1
        await asyncio.gather(*self._reviving)
        async with self._opening:
            await self._close()

    async def _close(self) -> None:
        stages = self._stages
        await asyncio.gather(*(stage.close() for stage in stages))
        for stage in stages:
            self.stops.discard(stage)
            self._loads.forget(stage)
        self._leader = self._twin = self._idle = None
        self.is_on = False

    def stop(self) -> str:
        """Stop, on any thread, for `improv stop`. Returns the line that answers it."""
        name = self._name if self.is_on or self._beginning else ""
        self.stops.stop()
        if not name:
            return IDLE
        line: WarningLine = {"type": "warning", "message": "stopped by `improv stop`"}
        if self._loop:
            with suppress(RuntimeError):  # the loop has been closed
                self._loop.call_soon_threadsafe(self._listen, line, True)
        return f"stopped {name} on {self.status}" if self._leader else f"stopped {name} before it began"

    async def _start_stage(self, sink: SinkName) -> RunningStage | None:
        stage = await self._start(sink, replace(self.options, port=self._port), self._token, self._hear, self.stops)
        if stage:
            if "page" in stage.ready:
                # Reuse the port, so a restarted stage serves the pages that are already open.
                self._port = urlsplit(stage.ready["page"]).port or 0
            for message in self._kept.values():
                stage.send(message)
            if stage.ready["real"] and self.stops.pressed["count"]:
                stage.send(self.stops.pressed)
            self.stops.add(stage)
        return stage

    def _send_score(self, score: Score, name: str, when: When, beats_per_bar: int, asked: int) -> bool:
        generation = self._generation + 1
        latest = Asked(self._editions.number(score, generation), generation, when, beats_per_bar, asked)
        if not self._send_to_leader(latest):
            return False
        self._score, self._name, self._generation, self.is_on = score, name, generation, True
        self._latest, self._entered = latest, None
        self._halting = None
        self._still.set()
        return True

    def _send_to_leader(self, asked: Asked) -> bool:
        assert self._leader
        load = self._loads.make(self._leader, asked, self.status)
        load["stops"] = self.stops.known  # as many as when it was asked for, or it is not sent
        if self._senses is not None:
            load["senses"] = self._senses
        sent = self.stops.send(load, [self._leader], asked.stops)
        if not sent:
            self._loads.forget(self._leader)
        return sent

    def _send_to_twin(self, asked: Asked, entered: TransportMessage) -> None:
        """Have the twin play a score from exactly where the leading stage began with it."""
        assert self._twin
        when: When = "restart" if entered["restarted"] == asked.generation else "now"
        load = self._loads.make(self._twin, replace(asked, when=when), self.status)
        if asked.score.open:
            self._behind = BEHIND
        elif when == "restart":
            self._behind = 0.0
        load["entry"] = {"beat": entered["beat"], "monotonic": entered["monotonic"] + self._behind}
        if "begins" in entered:
            load["entry"]["begins"] = entered["begins"]
        if "scene" in entered:
            load["entry"]["scene"] = entered["scene"]
        self._twin.send(load)

    def _send_again(self, stage: RunningStage, generation: int) -> None:
        """Send a stage the whole score: it did not get the one before, which this one counts on."""
        self._loads.forget(stage)
        latest = self._latest
        if not latest or latest.generation != generation:
            return
        if stage is self._leader:
            self._send_to_leader(latest)
        elif stage is self._twin and self._entered:
            self._send_to_twin(latest, self._entered)

    def _hear(self, stage: RunningStage, message: Heard, asked: int) -> None:
        leads = stage is self._leader
        if message["type"] == "request":
            self._obey(message["command"], asked)
            return
        if message["type"] == "lacks":
            self._send_again(stage, message["generation"])
            return
        if message["type"] == "sensed" or message["type"] == "decided":
            if leads and self._twin:
                self._twin.send(message)
            if not leads:
                return
        elif message["type"] == "measured" and leads and self._twin:
            self._twin.send(message)
        if message["type"] == "gone":
            self.stops.discard(stage)
            self._loads.forget(stage)
            message = self._revive(stage, message)
        elif message["type"] == "transport":
            if stage is self._halting and message["state"] in ("stopped", "ended"):
                self._still.set()
            if leads:
                self._lead(message)
        elif message["type"] == "pressed":
            self.stops.pressed = message
            asyncio.get_running_loop().call_later(KNOWN, self.stops.know, message["count"])
            return
        self._listen(message, leads)

    def _obey(self, request: PageRequest | Watched, asked: int) -> None:
        """Carry out a request from the page. It goes to all stages from here, so they never disagree.

        A stop has been obeyed already, when it arrived.
        """
        if request["type"] == "watched":
            self.watched.set()
        elif request["type"] == "restart":
            if self._leader and self._score:
                self._send_score(self._score, self._name, "restart", BEATS_PER_BAR, asked)
        elif request["type"] == "silence":
            self.silence(request["muted"], request["soloed"])
        elif request["type"] == "place" or request["type"] == "form":
            self._listen(request, True)
        elif request["type"] == "editing":
            if self._edit:
                self._edit(request, asked)
        elif request["type"] == "resume":
            self.resume(asked)
        elif request["type"] != "hush" and request["type"] != "pause":
            self.conduct(request)

    def _lead(self, transport: TransportMessage) -> None:
        """Start the twin at exactly the same time as the leading stage, and stop and pause it when that one does."""
        self.is_on = transport["state"] in ("waiting", "playing", "paused")
        waited, self._waits_for = self._waits_for, transport.get("waits_for", ())
        self._editions.plays(transport["generation"])
        if not self._twin:
            return
        latest, plays = self._latest, transport["state"] == "playing"
        if plays and latest and not self._entered and transport["generation"] == latest.generation:
            self._entered = transport
            self._send_to_twin(latest, transport)
        elif transport["state"] == "stopped":
            self._twin.send({"type": "hush"})
        elif transport["state"] == "paused" and self._waits_for:
            self._twin.send({"type": "pause", "at": transport["monotonic"]})
        elif transport["state"] == "playing" and waited:
            self._twin.send({"type": "resume", "at": transport["monotonic"]})

    def _revive(self, dead: RunningStage, gone: Gone) -> Gone:
        """Replace a stage that has died, and return the line that says so.

        A new stage of real robots first stops them, even if a standby should have: that one may have failed too.
        """
        leads, idles = dead is self._leader, dead is self._idle
        if leads:
            self.is_on, self._waits_for = False, ()
            if self._twin:
                self._twin.send({"type": "hush"})
        if not idles:
            self._latest = None
        again = "" if idles else "; save to play again"
        if dead is self._halting:  # another one would fail too
            moving = "" if self._still.is_set() else ": robots may still be moving"
            self._halting = None
            self._still.set()
            return {**gone, "message": f"{gone['message']}{moving}{again}"}
        task = asyncio.create_task(self._replace(dead))
        self._reviving.add(task)
        task.add_done_callback(self._reviving.discard)
        if not leads and not idles:
            what = "a new one will show the next dance"
        else:
            what = f"a new one is stopping the robots{again}"
        return {**gone, "message": f"{gone['message']}: {what}"}

    async def _replace(self, dead: RunningStage) -> None:
        async with self._opening:
            leads, idles = dead is self._leader, dead is self._idle
            if not leads and not idles and dead is not self._twin:
                return
            try:
                new = await self._start_stage("simulator" if "page" in dead.ready else "ros")
            except StageError as error:
                self._listen({"type": "error", "message": f"no new stage could be started: {error}"}, leads)
                new = None
            if idles:
                self._idle = new or dead  # a dead one has the next play start all stages
            elif leads:
                self._leader = new
            else:
                self._twin = new
                return
        scores = [self._idle_score] if idles and self._idle_score else self._editions.may_play
        if new and scores:
            self._halting = new
            self._still.clear()
            asked = Asked(_standing(scores), self._generation, "restart", BEATS_PER_BAR, self.stops.count)
            new.send(self._loads.make(new, asked, self.status))
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._still.wait(), HALT_LIMIT)


def _standing(scores: Collection[Score]) -> Score:
    """The robots of scores of which any may play, with nothing to play, so they are only told to stop.

    A robot may have another topic in each score. Then it counts as several.
    """
    robots = {part.topic: part for score in scores for part in score.parts.values()}
    parts: dict[str, Part] = {}
    for topic, part in robots.items():
        name = topic if part.robot in parts else part.robot
        parts[name] = replace(part, robot=name, scenes=(), reset=None)
    latest = [*scores][-1]
    return Score(latest.tempo, parts, world=latest.world)


async def _close_all(starting: Iterable[asyncio.Task[RunningStage | None]]) -> None:
    """Close the stages that have started and cancel those that have not."""
    for each in starting:
        each.cancel()
    for stage in await asyncio.gather(*starting, return_exceptions=True):
        if stage and not isinstance(stage, BaseException):
            await stage.close()
