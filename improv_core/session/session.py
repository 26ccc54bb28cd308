"""The parent's side of stages: starts them, and carries out decisions about them (`on_request`, `on_report`). Standard
library only."""

from __future__ import annotations

import asyncio
import math
import secrets
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import cast
from urllib.parse import urlsplit

from improv_core.ipc.stage_process import RunningStage, StageError
from improv_core.music.clock_process import ClockProcess, HeardClock
from improv_core.music.osc_link import OscLink
from improv_core.protocol.commands import Editing, Pause, Stop
from improv_core.protocol.messages import ToStage
from improv_core.protocol.tickets import issue
from improv_core.safety import stage_stops
from improv_core.safety.stop_socket import IDLE, StopSocketError, new_show
from improv_core.safety.stops import KNOWN, Stops
from improv_core.score.score import Host
from improv_core.session import on_hosts
from improv_core.session.acts import Act, Announce, HearClock, News, Now, Report, Send, SendScore, Start, StateAndActs
from improv_core.session.halting import stop_line
from improv_core.session.loads import Loads
from improv_core.session.on_report import on_clock, on_close, on_report, on_time
from improv_core.session.on_request import ProblemFields, Request, on_request, program_message
from improv_core.session.start import Options, StartStage, keep_reaching, start_stage, wait_for_stages
from improv_core.session.state import HERE, Output, PlayScore, SessionState, StageKey
from improv_core.session.together import HANDED, SPARE, host_of

LOST = "the stage ended before it had stopped its robots"
"""The reason why another stage has to stop its robots."""
HALT_LIMIT = 8.0
"""Seconds that a new stage may take to find the robots of a dead one and stop them."""
Edit = Callable[[Editing, int], None]
"""Handles a request from a page about the program; also gets the count of stops at that moment."""


class Playback:
    """Plays scores on the chosen backend: one leading stage or, on several machines, several that play as one; and if
    these move real robots, the simulator as their twin.

    `listen` gets every message from a stage, and whether that stage leads. Use it from one event loop only, except
    `stops`, `stop`, and `send`. Without `edit`, no page can edit the program.
    """

    def __init__(
        self,
        options: Options,
        listen: Callable[[News, bool], None],
        stops: Stops,
        start: StartStage = start_stage,
        edit: Edit | None = None,
        listen_to: type[ClockProcess] = ClockProcess,
    ) -> None:
        self.options = options
        self.stops = stops
        self.state = SessionState()
        """The state of the session; only to be read."""
        self.begins_with = ""
        """The name of the program to play once everything has started, until somebody plays one; empty if none."""
        self._listen = listen
        self._edit = edit
        self._start = start
        self._listen_to = listen_to
        self._clock: ClockProcess | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._stages: dict[StageKey, RunningStage] = {}
        self._loads = Loads()
        self._asleep = 0.0  # the seconds that the machine had slept when somebody asked for the latest score
        self._stopped: deque[Stop | Pause] = deque()  # stops and pauses that robots were sent, and nothing knows of
        self._timer: asyncio.TimerHandle | None = None
        self._reaching: dict[StageKey, asyncio.Task[None]] = {}  # the hosts that are tried again
        self._ending = False
        self._opening = asyncio.Lock()
        self.starting: dict[StageKey, asyncio.Task[bool]] = {}  # the first starts of its stages, done or not
        self._show: Path | None = None  # the path with which the names of the stages' stop sockets begin
        with suppress(StopSocketError):  # then real robots have no `improv stop` either, and don't move
            self._show = new_show()
        self._osc = OscLink(options.osc, stops, self.ask, self._warn, show=self._show)
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

    def present(
        self, name: str, folder: str, errors: Iterable[ProblemFields] = (), names: Mapping[str, str] | None = None
    ) -> None:
        """Have pages show the program to play, its errors, and its robots' other `names` there, if any."""
        self.ask(program_message(name, folder, [*errors], names))

    async def open(self, hosts: frozenset[Host] = frozenset()) -> None:
        """Start the stages, also those of these hosts, unless they are running. Raises StageError."""
        self._loop = asyncio.get_running_loop()
        hosts = frozenset() if self.options.backend == "sim" else hosts
        async with self._opening:
            if self.state.is_open and hosts <= self._hosts:
                return
            await self._end_stages()
            self._forget()
            self._hosts = hosts
            backend = self.options.backend
            outputs: list[Output] = ["ros"] if backend != "sim" else []
            if backend != "ros":
                outputs.append("simulator")
            elif self.options.page:
                outputs.append("page")
            away = {host.name: HANDED if host.output else SPARE for host in hosts}
            self.state = self.state.opening({HERE: HANDED, **away} if away else {})
            keys = [*(StageKey(HERE, output) for output in outputs), *(StageKey(host, "ros") for host in sorted(away))]
            self.starting = starting = {key: asyncio.create_task(self._start_stage(key)) for key in keys}
            try:
                # Wait for all even if one fails, so that no stage is left running unnoticed.
                for key in await wait_for_stages(starting, lambda: bool(self.state.alive), self._warn):
                    self._reach(key, starting[key])
                self.state = self.state.opened(outputs)
                if self.state.is_real and self.stops.unreachable:
                    raise StageError(f"real robots need `improv stop`: {self.stops.unreachable}")
            except BaseException:
                for each in starting.values():
                    each.cancel()
                await asyncio.gather(*starting.values(), return_exceptions=True)
                await self._end_stages()
                self._forget()
                raise

    def _reach(self, key: StageKey, first: asyncio.Task[bool] | None = None) -> None:
        start = partial(self._start_stage, key)
        self._reaching[key] = asyncio.create_task(keep_reaching(key.host, start, self._warn, first))

    async def play(self, play: PlayScore) -> int | None:
        """Play a program's score, and return its generation; None if a stop has come since somebody asked for it, or if
        an emergency stop is on.

        Raises StageError, also if it is to be simulated and there is no simulator.
        """
        ends, self.begins_with = self._ends, ""
        self._beginning.append(play.name)
        self._osc.expect(play.score)
        try:
            await self.open(frozenset() if play.simulated else play.score.hosts)
            await self._osc.ready()
        finally:
            self._beginning.remove(play.name)
        if self._ends != ends:
            return None
        before = self.state.generation
        self._decide(lambda state: on_request(state, play, self._now(play.stops)))
        return self.state.generation if self.state.generation != before else None

    def ask(self, request: Request, stops: int = 0) -> None:
        """Have all stages do something, at the same time. To resume, `stops` is the count when somebody asked for it:
        after a stop since then, they don't."""
        self._decide(lambda state: on_request(state, request, self._now(stops)))

    def send(self, message: ToStage) -> None:
        """Send all stages of real robots a stop or a pause, on any thread, for `Stops`."""
        timed = on_hosts.in_time(self.state, message, Now(time.monotonic()))
        self._stopped.append(cast(Stop | Pause, message))  # first, because an answer to an unknown stop is ignored
        for key, stage in [*self._stages.items()]:
            if key.output == "ros":
                stage.send(timed)
        if self._loop:
            with suppress(RuntimeError):  # the loop was closed
                self._loop.call_soon_threadsafe(self._decide, lambda state: (state, []))

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
        if self._replacing:  # a new stage takes its time to start, even if it only shows what others play
            self.send({"type": "stop"})
        await asyncio.gather(*self._replacing)
        async with self._opening:
            lost = await self._end_stages()
            if not lost:
                self._forget()
                return
            for key in lost:
                self._hear(key, {"type": "gone", "message": LOST})
        await asyncio.gather(*self._replacing)
        if not self.state.obeys:
            robots = [robot for each in lost.values() for robot in each]
            line = f"{', '.join(robots)} may still be moving: no stage could stop them"
            generation = self.state.generation
            self._listen({"type": "unreached", "generation": generation, "robots": robots, "message": line}, True)
        async with self._opening:
            await self._end_stages()
            self._forget()

    def _forget(self) -> None:
        self._stages.clear()
        if self._show:
            stage_stops.forget(self._show)
        self._decide(lambda state: (state.closed(), [HearClock(None)]))

    async def _end_stages(self) -> dict[StageKey, list[str]]:
        """End all stages. Returns the real robots of those here that were killed before they could stop them."""
        self._ending = True
        if self.state.is_spread:
            self.send({"type": "stop"})
        for each in self._reaching.values():
            each.cancel()
        await asyncio.gather(*self._reaching.values(), return_exceptions=True)
        self._reaching.clear()
        stages = [*self._stages.items()]
        await asyncio.gather(*(stage.close() for _, stage in stages))
        self.stops.discard(self)
        for _, stage in stages:
            self.stops.discard(stage)
        self._ending = False
        if self.state.is_spread:
            self._decide(on_close)
            return {}
        return {key: robots for key, stage in stages if (robots := self._moving(key, stage))}

    def stop(self, stop: Stop) -> str:
        """Obey `improv stop`, on any thread. Returns the line of the answer."""
        asked, state = stop.get("at"), self.state
        was_on = state.is_on or (asked is not None and self._went_off >= asked)  # stages may have obeyed it by now
        moving = [robot for key, stage in [*self._stages.items()] for robot in self._moving(key, stage)]
        begins = [name for name in (self.begins_with, *self._beginning) if name][-1:]
        self.stops.stop(stop)
        line = stop_line(state, begins, len(moving), was_on)
        if line != IDLE and self._loop:
            with suppress(RuntimeError):  # the loop has been closed
                self._loop.call_soon_threadsafe(self._warn, "stopped by `improv stop`")
        return line

    def _moving(self, key: StageKey, stage: RunningStage) -> list[str]:
        """Return the real robots that a stage moves by its reports, not by its score, or moved when it was killed."""
        state = self.state
        robots = state.played.score.moving().parts if state.played and key.output == "ros" else ()
        return stage.moving(robot for robot in robots if host_of(state, robot) == key.host)

    def _now(self, stops: int = 0) -> Now:
        overtaken = stops != self.stops.count
        return Now(
            time.monotonic(), time.time(), stops, overtaken, self.stops.stopped, self.stops.pressed, self.stops.known
        )

    def _warn(self, line: str) -> None:
        self._listen({"type": "warning", "message": line}, True)

    def _hear(self, key: StageKey, message: Report, stops: int = 0) -> None:
        if message["type"] == "gone" and self.state.is_spread and key.output == "ros":
            self._stages.pop(key, None)
        self._decide(lambda state: on_report(state, key, message, self._now(stops)))

    def _hear_clock(self, message: HeardClock) -> None:
        self._decide(lambda state: on_clock(state, message, self._now()))

    def _decide(self, decide: Callable[[SessionState], StateAndActs]) -> None:
        """Decide about something, after the stops and pauses that came before it."""
        while self._stopped:
            self._do(on_request(self.state, self._stopped.popleft(), self._now()))
        self._do(decide(self.state))

    def _do(self, decided: StateAndActs) -> None:
        was_on = self.state.is_on
        self.state, acts = decided
        if was_on and not self.state.is_on:
            self._went_off = time.monotonic()
        (self._still.set if self.state.still else self._still.clear)()
        for act in acts:
            self._do_one(act)
        if self._timer:
            self._timer.cancel()
            self._timer = None
        if self.state.is_spread and (at := on_hosts.due(self.state, self._now())) < math.inf:
            wake = partial(self._decide, lambda state: on_time(state, self._now()))
            self._timer = asyncio.get_running_loop().call_at(at, wake)

    def _do_one(self, act: Act) -> None:
        match act:
            case Send(to, message, after, unless):
                if not (stage := self._stages.get(to)):
                    return
                if unless is not None:
                    self.stops.send(message, stage, unless)
                elif after:
                    asyncio.get_running_loop().call_later(after, stage.send, message)
                else:
                    stage.send(message)
            case SendScore():
                self._send_score(act)
            case Announce(news, leads, stops):
                self._tell(news, leads, stops)
            case Start(key) if self.state.is_spread and key.output == "ros":
                if not self._ending:
                    self._reach(key)
            case Start(key):
                task = asyncio.create_task(self._start_again(key))
                self._replacing.add(task)
                task.add_done_callback(self._replacing.discard)
            case HearClock(clock, tempo):
                if self._clock:
                    self._clock.close()
                self._clock = self._listen_to(clock, tempo, self._hear_clock) if clock else None

    def _tell(self, news: News | Editing, leads: bool, stops: int) -> None:
        if news["type"] == "pressed":
            self.stops.pressed = news
            asyncio.get_running_loop().call_later(KNOWN, self.stops.know, news["count"])
        elif news["type"] == "editing":
            if self._edit:
                self._edit(news, stops)
        else:
            if leads and (news["type"] == "transport" or news["type"] == "sensed" or news["type"] == "armed"):
                self._osc.tell(news)
            self._listen(news, leads)

    def _send_score(self, act: SendScore) -> None:
        act = replace(act, to=[key for key in act.to if key in self._stages])
        loads = [(self._stages[key], load) for key, load in self._loads.of(self.state, act).items()]
        if not act.asked:
            for stage, load in loads:
                if act.stops:  # it joins: somebody has asked for this before
                    load["asleep"] = self._asleep
                stage.send(load)
        elif self.stops.send_all(loads, act.play.stops):
            self._asleep = next((load["asleep"] for _, load in loads), self._asleep)
            self._osc.plays(act.play.score, act.play.generation)
            self._hear(StageKey(HERE, self.state.leader or "ros"), {"type": "loaded", "play": act.play})
        else:
            self._loads.forget(act.to)  # they lack this score

    async def _start_stage(self, key: StageKey) -> bool:
        """Start a stage. Returns whether there is one."""
        host = next((host for host in self._hosts if host.name == key.host), None)
        # With hosts, robots may all be elsewhere: then it doesn't matter if there is no ROS here.
        backend = "auto" if self._hosts else self.options.backend
        options = replace(self.options, backend=backend, port=self._port, host=host, show=self._show)
        dead = self.state.stages.get(key)
        if self._show and not (dead and dead.died_moving):
            stage_stops.forget(self._show, key.host or key.output)
        stage = await self._start(
            key.output, options, self._token, lambda _, heard, stops: self._hear(key, heard, stops), self.stops
        )
        if not stage:
            return False
        if "page" in stage.ready:
            # Reuse the port, so a restarted stage serves the pages that are already open.
            self._port = urlsplit(stage.ready["page"]).port or 0
        if before := self._stages.get(key):
            self.stops.discard(before)
        self._stages[key] = stage
        self._loads.forget([key])
        self._hear(key, stage.ready)
        if key.output == "ros":
            self.stops.add(self)  # until the end: while none moves them, no stage reports that robots stand
        else:
            self.stops.add(stage)
        return True

    async def _start_again(self, key: StageKey) -> None:
        async with self._opening:
            dead = self.state.stages.get(key)
            if not dead or dead.alive:
                return
            why = "no Python has rclpy"
            try:
                found = await self._start_stage(key)
            except StageError as error:
                found, why = False, str(error)
            if not found:
                self._hear(key, {"type": "failed", "message": why})
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._still.wait(), HALT_LIMIT)
