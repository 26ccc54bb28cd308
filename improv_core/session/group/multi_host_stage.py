"""Stages on several machines that look like one: has their processes and the timer, and carries out the decisions of
`rules`. Standard library only."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial

from improv_core.ipc.stage_process import Heard, Stage, StageError
from improv_core.protocol.commands import is_stop
from improv_core.protocol.messages import VERSION, Ready, ToStage
from improv_core.session.group import rules
from improv_core.session.group.acts import Decided, Say, SendTo, StartHost, Times, warning
from improv_core.session.group.state import HERE, GroupState, Hosted

PAUSES = (1.0, 2.0, 4.0, 8.0, 15.0)
"""Seconds before each attempt to reach a host again; the last one repeats."""

SLOW = 5.0
"""Seconds after which a line names the hosts that have not answered."""
LATEST = 15.0
"""Seconds after which the others begin without a host that has not answered: its stage joins them once it does."""

HearMember = Callable[[Stage, Heard, int], None]
StartMember = Callable[[str, HearMember], Awaitable[Stage | None]]
"""Starts the stage of a host. None if there can be none here. Raises StageError."""
HearAll = Callable[["MultiHostStage", Heard, int], None]
Forget = Callable[[str], None]
"""Called with a host's name before its stage starts, unless that stage replaces one whose robots may still move."""


class MultiHostStage:
    """Several stages, by their hosts. Made by `start`. `send` may be called on any thread for stops and pauses."""

    def __init__(self, hosts: Sequence[str], start: StartMember, hear: HearAll, forget: Forget) -> None:
        self._group = GroupState({host: Hosted(alive=False) for host in hosts})
        self._start_member = start
        self._hear = hear
        self._forget = forget
        self._loop = asyncio.get_running_loop()
        self._stages: dict[str, Stage] = {}
        self._stopped: deque[ToStage] = deque()  # stops and pauses that were sent and have yet to be noted
        self._again: dict[str, asyncio.Task[None]] = {}
        self._timer: asyncio.TimerHandle | None = None
        self._closing = False

    @classmethod
    async def start(
        cls, hosts: Sequence[str], start: StartMember, hear: HearAll, forget: Forget = lambda host: None
    ) -> MultiHostStage:
        """Start the stages of all hosts. One that can't be reached is tried again later, and the wait for one that
        doesn't answer is limited. Raises StageError if none can be started, or if the one here fails."""
        made = cls(hosts, start, hear, forget)
        starting = {host: asyncio.create_task(made._start(host)) for host in hosts}
        try:
            await made._reach(starting)
            problems = {host: why for host, each in starting.items() if each.done() and (why := each.exception())}
            for host, problem in problems.items():
                if host == HERE or not made._stages or not isinstance(problem, StageError):
                    raise problem
            if not made._stages:
                raise StageError("no stage could be started")
        except BaseException:
            for each in starting.values():
                each.cancel()
            await asyncio.gather(*starting.values(), return_exceptions=True)
            await made.close()
            raise
        for host, each in starting.items():
            if not each.done():
                made._again[host] = asyncio.create_task(made._reach_late(host, each))
        for host, problem in problems.items():
            made._loop.call_soon(made._try_later, host, str(problem))
        return made

    @property
    def ready(self) -> Ready:
        """Return the stages' first messages as one."""
        sinks = [
            f"{stage.ready['sink']} on {host}" if host else stage.ready["sink"] for host, stage in self._stages.items()
        ]
        return {"type": "ready", "protocol": VERSION, "sink": "; ".join(sinks), "real": True}

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return which of these robots move, by each stage's latest report. Callable from any thread."""
        group, names = self._group, [*robots]
        return [
            robot
            for host, stage in [*self._stages.items()]
            for robot in stage.moving(name for name in names if group.owns(host, name))
        ]

    def send(self, message: ToStage) -> None:
        """Send all a message. A stop goes to all at once."""
        if is_stop(message):
            timed = rules.in_time(self._group, message, _now())
            self._stopped.append(message)  # before sending, because an answer to an unrecorded stop is ignored
            for stage in [*self._stages.values()]:
                stage.send(timed)
            with suppress(RuntimeError):  # the loop was closed
                self._loop.call_soon_threadsafe(self._note_stops)
        else:
            self._note_stops()
            self._do(rules.told(self._group, message, _now()))

    async def close(self) -> None:
        """Stop the robots and end the stages. Names robots that may still move, since no stage has confirmed their
        stop."""
        self.send({"type": "stop"})
        self._closing = True
        for task in self._again.values():
            task.cancel()
        await asyncio.gather(*self._again.values(), return_exceptions=True)
        await asyncio.gather(*(stage.close() for stage in self._stages.values()))
        self._note_stops()
        self._do(rules.unconfirmed(self._group))
        if self._timer:
            self._timer.cancel()
        self._stages.clear()

    async def _reach(self, starting: Mapping[str, asyncio.Task[None]]) -> None:
        """Wait until all have started or failed, or the time limit for the remaining hosts has passed."""

        def late() -> list[str]:
            return [host for host, each in starting.items() if host != HERE and not each.done()]

        await asyncio.wait(starting.values(), timeout=SLOW)
        if late():
            wait = f"the others wait for up to {LATEST:g} s"
            self._do((self._group, [warning(f"{', '.join(late())} has not answered for {SLOW:g} s: {wait}")]))
            await asyncio.wait(starting.values(), timeout=LATEST - SLOW)
        if HERE in starting:
            await asyncio.wait([starting[HERE]])
        while late() and not self._stages:
            await asyncio.wait([starting[host] for host in late()], return_when=asyncio.FIRST_COMPLETED)
        if late():
            line = f"{', '.join(late())} has not answered for {LATEST:g} s: the others begin, and it joins them"
            self._do((self._group, [warning(line)]))

    async def _reach_late(self, host: str, starting: asyncio.Task[None]) -> None:
        """Wait for a host after the others have begun without it."""
        try:
            await starting
        except StageError as error:
            self._try_later(host, str(error))

    async def _start(self, host: str) -> None:
        if not self._group.members[host].died_moving:
            self._forget(host)
        stage = await self._start_member(host, partial(self._heard, host))
        if stage:
            self._stages[host] = stage
            self._do(rules.started(self._group, host, _now()))

    def _heard(self, host: str, stage: Stage, message: Heard, stops: int) -> None:
        self._note_stops()
        if message["type"] == "request":
            self._hear(self, message, stops)
            return
        if message["type"] == "gone":
            self._stages.pop(host, None)
        self._do(rules.said(self._group, host, message, _now()))

    def _note_stops(self) -> None:
        """Decide about stops and pauses before anything else that came after them."""
        while self._stopped:
            self._do(rules.told(self._group, self._stopped.popleft(), _now()))

    def _do(self, decided: Decided) -> None:
        self._group, acts = decided
        for act in acts:
            match act:
                case SendTo(host, message):
                    if host in self._stages:
                        self._stages[host].send(message)
                case Say(message):
                    self._hear(self, message, 0)
                case StartHost(host) if not self._closing:
                    self._again[host] = asyncio.create_task(self._start_again(host))
        self._wait()

    def _wait(self) -> None:
        if self._timer:
            self._timer.cancel()
        at = rules.due(self._group, _now())
        if at < math.inf:
            self._timer = self._loop.call_at(at, self._waited)

    def _waited(self) -> None:
        self._timer = None
        self._do(rules.waited(self._group, _now()))

    def _try_later(self, host: str, problem: str) -> None:
        self._do((self._group, [_cannot_be_reached(host, problem)]))
        self._again[host] = asyncio.create_task(self._start_again(host, problem))

    async def _start_again(self, host: str, told: str = "") -> None:
        """Try until it works. The reason for a failure that people were `told` last is not repeated."""
        attempt = 0
        while not self._closing:
            await asyncio.sleep(PAUSES[min(attempt, len(PAUSES) - 1)])
            attempt += 1
            try:
                await self._start(host)
            except StageError as error:
                if str(error) != told:
                    told = str(error)
                    self._do((self._group, [_cannot_be_reached(host, told)]))
            else:
                return


def _cannot_be_reached(host: str, problem: str) -> Say:
    who = host or "the stage here"
    return Say({"type": "warning", "message": f"{who} can't be reached: {problem} (Improv keeps trying)"})


def _now() -> Times:
    return Times(time.monotonic(), time.time())
