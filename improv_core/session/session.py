"""The parent's side of stages: starts them, and carries out decisions about them (`asked`, `heard`). Standard library
only."""

from __future__ import annotations

import asyncio
import math
import secrets
import time
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Protocol, TypeAlias
from urllib.parse import urlsplit

from improv_core.ipc.stage_process import Heard, StageError
from improv_core.music.clock_process import ClockProcess, HeardClock
from improv_core.music.osc_link import OscLink
from improv_core.protocol.commands import Editing, PageRequest, Stop
from improv_core.protocol.messages import Load, Problem, Ready, ToStage
from improv_core.protocol.tickets import issue
from improv_core.safety import stage_stops
from improv_core.safety.halts import KNOWN
from improv_core.safety.stop_socket import IDLE, StopSocketError, new_show
from improv_core.safety.stops import Stops
from improv_core.score.score import Host, OutsideClock
from improv_core.score.score_json import RowsWritten, to_json
from improv_core.session.acts import Act, Announce, Failed, HearClock, Loaded, News, Send, SendScore, StartAgain
from improv_core.session.on_request import Decided, Now, StageRequest, asked
from improv_core.session.on_stage_message import heard, heard_clock
from improv_core.session.start import Options, SinkName, start_stage
from improv_core.session.state import PlayScore, SessionState

LOST = "the stage ended before it had stopped its robots"
"""The reason why another one has to stop them."""
HALT_LIMIT = 8.0
"""Seconds that a new stage may take to find the robots of a dead one and stop them."""

MOST_MISTAKES = 20
"""The most errors that pages list."""

Mistake = tuple[str, int, int, str, str]
"""An error that keeps a program from being played: the file, the line and the column from 1, the word there, and a
message."""
Edit = Callable[[Editing, int], None]
"""Handles a request from a page about the program; also gets the count of stops at that moment."""


class RunningStage(Protocol):
    """The part of stage_process.Stage that a playback uses."""

    @property
    def ready(self) -> Ready: ...

    def send(self, message: ToStage) -> None: ...

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return which of these robots move, by the latest report. Callable from any thread."""

    async def close(self) -> None: ...


Hear: TypeAlias = Callable[[RunningStage, Heard, int], None]
Start: TypeAlias = Callable[[SinkName, Options, str, Hear, Stops], Awaitable[RunningStage | None]]
"""The type of start.start_stage."""


class RunningClock(Protocol):
    """The part of clock_process.ClockProcess that a playback uses."""

    def close(self) -> None: ...


ListenTo: TypeAlias = Callable[[OutsideClock, float, Callable[[HeardClock], None]], RunningClock]
"""Listens to a clock of music, and passes its messages on."""


class Playback:
    """Plays scores on the chosen backend: one leading stage and, if that is ROS 2, the simulator as its twin.

    `listen` gets every message from a stage, and whether that stage leads. Use it from one event loop only, except
    `stops` and `stop`. Without `edit`, no page can change the program.
    """

    def __init__(
        self,
        options: Options,
        listen: Callable[[News, bool], None],
        stops: Stops,
        start: Start = start_stage,
        edit: Edit | None = None,
        listen_to: ListenTo = ClockProcess,
    ) -> None:
        self.options = options
        self.stops = stops
        self.state = SessionState()
        """The state of the session; only to be read."""
        self.begins_with = ""
        """The name of the program to play once everything has started, until somebody plays one; empty if there is
        none."""
        self._listen = listen
        self._edit = edit
        self._start = start
        self._listen_to = listen_to
        self._clock: RunningClock | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stages: dict[SinkName, RunningStage] = {}
        self._written: dict[SinkName, RowsWritten] = {}  # the movements that each stage has
        self._opening = asyncio.Lock()
        self._show: Path | None = None  # the path with which the names of the stages' stop sockets begin
        with suppress(StopSocketError):  # then real robots have no `improv stop` either, and don't move
            self._show = new_show()
        self._osc = OscLink(options.osc, stops, self._ask_for, self._say, show=self._show)
        self._beginning: list[str] = []  # programs that wait for the stages to start
        self._ends = 0  # the number of times that everything had to end
        self._replacing: set[asyncio.Task[None]] = set()
        self._still = asyncio.Event()
        self._went_off = -math.inf  # the latest time at which all that was on had stopped, by the reports of stages
        self._hosts: frozenset[Host] = frozenset()  # the hosts whose stages have been started
        self._token = secrets.token_urlsafe()
        self._port = options.port

    def link(self, *, own: bool = False) -> str | None:
        """Return a new URL that opens the page once. A URL for starting a browser has to be this user's `own`, since
        others can see it in the list of processes."""
        return f"{self.state.page}?ticket={issue(self._token, own=own)}" if self.state.page else None

    def present(self, name: str, folder: str, mistakes: Iterable[Mistake] = ()) -> None:
        """Have pages show the program to play, and the errors that keep it from being played."""
        problems: list[Problem] = [
            {"file": file, "line": line, "column": column, "word": word, "message": message}
            for file, line, column, word, message in mistakes
        ]
        shown, count = problems[:MOST_MISTAKES], len(problems)
        self.ask({"type": "program", "name": name, "folder": folder, "problems": shown, "count": count})

    async def open(self, hosts: frozenset[Host] = frozenset()) -> None:
        """Start the stages, also those of these hosts, unless they are running. Raises StageError."""
        self._loop = asyncio.get_running_loop()
        async with self._opening:
            if self.state.is_open and hosts <= self._hosts:
                return
            await self._close()
            self._hosts = hosts
            backend = self.options.backend
            sinks: list[SinkName] = ["ros"] if backend != "sim" else []
            if backend != "ros":
                sinks.append("simulator")
            elif self.options.page:
                sinks.append("page")
            starting = [asyncio.create_task(self._start_stage(sink)) for sink in sinks]
            try:
                # Wait for both even if one fails, so that no stage is left running unnoticed.
                await asyncio.wait(starting)
                for each in starting:
                    each.result()
                self.state = self.state.opened(sinks)
                if self.state.is_real and self.stops.unreachable:
                    raise StageError(f"real robots need `improv stop`: {self.stops.unreachable}")
            except BaseException:
                for each in starting:
                    each.cancel()
                await asyncio.gather(*starting, return_exceptions=True)
                await self._close()
                raise

    async def play(self, play: PlayScore) -> int | None:
        """Play a program's score, and return its generation; None if a stop has come since somebody asked for it, or if
        an emergency stop is on.

        Raises StageError, also if it is to be simulated and there is no simulator.
        """
        ends, self.begins_with = self._ends, ""
        self._beginning.append(play.name)
        self._osc.expect(play.score)
        try:
            await self.open(frozenset() if play.simulated or self.options.backend == "sim" else play.score.hosts)
            await self._osc.ready()
        finally:
            self._beginning.remove(play.name)
        if self._ends != ends:
            return None
        before = self.state.generation
        self._do(asked(self.state, play, self._now(play.stops)))
        return self.state.generation if self.state.generation != before else None

    def ask(self, wish: StageRequest, stops: int = 0) -> None:
        """Have all stages do something, at the same time. To resume, `stops` is the count when somebody asked for it:
        after a stop since then, they don't."""
        self._do(asked(self.state, wish, self._now(stops)))

    def keep_as(self, other: Playback) -> None:
        """Take over the speed, the muted and soloed robots, and the open pages of another playback.

        The generations here continue its count, so no score here has the number of one there that may still be ending.
        """
        self.state = replace(self.state, kept=other.state.kept, generation=other.state.generation)
        self._token = other._token

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._ends += 1
        self._osc.close()
        await asyncio.gather(*self._replacing)
        async with self._opening:
            lost = await self._end_stages()
            if not lost:
                self._forget()
                return
            for name in lost:
                self._heard(name, {"type": "gone", "message": LOST})
        await asyncio.gather(*self._replacing)
        if not self.state.obeys:
            robots = [robot for each in lost.values() for robot in each]
            line = f"{', '.join(robots)} may still be moving: no stage could stop them"
            generation = self.state.generation
            self._listen({"type": "unreached", "generation": generation, "robots": robots, "message": line}, True)
        async with self._opening:
            await self._close()

    async def _close(self) -> None:
        await self._end_stages()
        self._forget()

    def _forget(self) -> None:
        self._stages.clear()
        if self._show:
            stage_stops.forget(self._show)
        self._hear_clock(None)
        self._do((self.state.closed(), []))

    async def _end_stages(self) -> dict[SinkName, list[str]]:
        """End all stages. Returns the real robots of those that were killed before they could stop them."""
        stages = [*self._stages.items()]
        await asyncio.gather(*(stage.close() for _, stage in stages))
        for _, stage in stages:
            self.stops.discard(stage)
        return {name: robots for name, stage in stages if (robots := self._moving(stage))}

    def stop(self, stop: Stop) -> str:
        """Obey `improv stop`, on any thread. Returns the line of the answer."""
        asked, state = stop.get("at"), self.state
        was_on = state.is_on or (asked is not None and self._went_off >= asked)  # stages may have obeyed it by now
        moving = [robot for stage in [*self._stages.values()] for robot in self._moving(stage)]
        names = [name for name in (self.begins_with, *self._beginning) if name][-1:]
        self.stops.stop(stop)
        lost = state.real is not None and not state.obeys
        if state.played and (was_on or moving or lost):
            names = [state.played.name]
        if not names:
            return IDLE
        if self._loop:
            with suppress(RuntimeError):  # the loop has been closed
                line: News = {"type": "warning", "message": "stopped by `improv stop`"}
                self._loop.call_soon_threadsafe(self._listen, line, True)
        if lost:
            return f"{names[0]}: robots may still be moving, since their stage has failed: look at them"
        if not (was_on or moving):
            return f"stopped {names[0]} before it began"
        if not moving:  # how many moved when somebody asked is not known
            return f"stopped {names[0]} on {state.status}"
        count = "1 robot was" if len(moving) == 1 else f"{len(moving)} robots were"
        return f"stopped {names[0]} on {state.status}: {count} moving"

    def _moving(self, stage: RunningStage) -> list[str]:
        """Return the real robots that a stage moves, by its reports and not by its score; also those that it moved when
        it was killed."""
        played = self.state.played
        return stage.moving(played.score.moving().parts if played and stage.ready["real"] else ())

    def _now(self, stops: int) -> Now:
        return Now(time.monotonic(), stops, self.stops.pressed)

    def _ask_for(self, request: PageRequest, stops: int) -> None:
        """Obey an OSC message as if it were a page's request."""
        self._do(asked(self.state, request, self._now(stops)))

    def _say(self, line: str) -> None:
        self._listen({"type": "warning", "message": line}, True)

    def _hear(self, name: SinkName, stage: RunningStage, message: Heard, stops: int) -> None:
        if message["type"] == "pressed":
            self.stops.pressed = message
            asyncio.get_running_loop().call_later(KNOWN, self.stops.know, message["count"])
        else:
            self._heard(name, message, stops)

    def _heard(self, name: SinkName, message: Heard | Loaded | Failed, stops: int = 0) -> None:
        self._do(heard(self.state, name, message, self._now(stops)))

    def _do(self, decided: Decided) -> None:
        was_on = self.state.is_on
        self.state, acts = decided
        if was_on and not self.state.is_on:
            self._went_off = time.monotonic()
        (self._still.set if self.state.still else self._still.clear)()
        for act in acts:
            self._do_one(act)

    def _do_one(self, act: Act) -> None:
        match act:
            case Send(name, message, after, unless):
                if unless is not None:
                    self.stops.send(message, self._stages[name], unless)
                elif after:
                    asyncio.get_running_loop().call_later(after, self._stages[name].send, message)
                else:
                    self._stages[name].send(message)
            case SendScore():
                self._send_score(act)
            case Announce(news, leads, stops):
                if news["type"] == "editing":
                    if self._edit:
                        self._edit(news, stops)
                    return
                if leads and (news["type"] == "transport" or news["type"] == "sensed" or news["type"] == "armed"):
                    self._osc.tell(news)
                self._listen(news, leads)
            case StartAgain(name):
                task = asyncio.create_task(self._start_again(name))
                self._replacing.add(task)
                task.add_done_callback(self._replacing.discard)
            case HearClock(clock, tempo):
                self._hear_clock(clock, tempo)

    def _hear_clock(self, clock: OutsideClock | None, tempo: float = 0.0) -> None:
        """Listen to a clock of music, and no longer to another one."""
        if self._clock:
            self._clock.close()
        self._clock = None
        if clock:
            self._clock = self._listen_to(clock, tempo, lambda message: self._do(heard_clock(self.state, message)))

    def _send_score(self, act: SendScore) -> None:
        name, play, stage = act.name, act.play, self._stages[act.name]
        written = self._written[name] = RowsWritten() if act.whole else self._written[name].renewed()
        load: Load = {
            "type": "load",
            "generation": play.generation,
            "score": to_json(play.score, written),
            "when": play.when,
            "backend": self.state.status,
            "beats_per_bar": play.beats_per_bar,
        }
        if act.entry:
            load["entry"] = act.entry
        if not act.asked:
            stage.send(load)
            return
        load["stops"] = self.stops.known  # if the number has changed since somebody asked for it, it is not sent
        if play.senses is not None:
            load["senses"] = play.senses
        if play.anyway:
            load["anyway"] = True
        if play.arming is not None:
            load["arming"] = play.arming
        if play.by:
            load["by"] = play.by
        if self.stops.send(load, stage, play.stops):
            self._osc.plays(play.score, play.generation)
            self._heard(name, {"type": "loaded", "play": play})
        else:
            self._written[name] = RowsWritten()  # the stage lacks this score

    async def _start_stage(self, name: SinkName) -> bool:
        """Start a stage. Returns whether there is one."""
        hosts = sorted(self._hosts, key=lambda host: host.name)
        options = replace(self.options, port=self._port, hosts=hosts, show=self._show)
        if self._show and not self.state.halts(name):
            stage_stops.forget(self._show, name)
        stage = await self._start(name, options, self._token, partial(self._hear, name), self.stops)
        if not stage:
            return False
        if "page" in stage.ready:
            # Reuse the port, so a restarted stage serves the pages that are already open.
            self._port = urlsplit(stage.ready["page"]).port or 0
        if dead := self._stages.get(name):
            self.stops.discard(dead)  # not before: until then, no stage reports that its robots stand
        self._stages[name], self._written[name] = stage, RowsWritten()
        self._heard(name, stage.ready)
        self.stops.add(stage, real=stage.ready["real"])
        return True

    async def _start_again(self, name: SinkName) -> None:
        async with self._opening:
            if name not in self.state.gone:
                return
            why = "no Python has rclpy"
            try:
                found = await self._start_stage(name)
            except StageError as error:
                found, why = False, str(error)
            if not found:
                self._heard(name, {"type": "failed", "message": why})
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._still.wait(), HALT_LIMIT)
