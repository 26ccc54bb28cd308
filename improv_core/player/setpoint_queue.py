"""A robot's setpoints, and the queue that sends them when they are due: each change of velocity at its exact time, then
zeros, and repeats in between.

It never reads a clock; times are performance times, in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from improv_core.player.repeats import Repeats
from improv_core.safety.pending_zeros import LAST_ZEROS
from improv_core.score.motion import STILL, Twist
from improv_core.score.movement import Exact, Movement
from improv_core.score.performance import Mover
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, twist
from improv_core.score.walk import walk

SHORTEST = Fraction(1, 1000)
"""Seconds. Faster changes are sampled at this interval, so no program can flood a robot. Only a seek may lead closer to
the next change."""

Velocity = Twist | Mapping[str, float]
"""The velocity of a base, or of the joints of a body part, by name, in rad/s or m/s. A zero twist stops either."""


class Setpoint(NamedTuple):
    """A velocity of a base or a body part from `at` seconds on. If it is `held`, it is repeated until the next one."""

    at: float
    velocity: Velocity
    held: bool


class MoverCommand(NamedTuple):
    """The velocity of a mover from a performance time on."""

    mover: Mover
    velocity: Velocity
    at: float


class SetpointQueue:
    """The next setpoint of each mover, which is a robot's base or one of its body parts, and the velocities they hold.

    `ready` gets commands ready, and returns a function that sends them all. `stands` returns whether a robot must stand
    now although its part moves it; then `withhold` gets its command instead.
    """

    def __init__(
        self,
        ready: Callable[[Sequence[MoverCommand]], Callable[[], None]],
        stands: Callable[[str], bool],
        withhold: Callable[[MoverCommand], None] = lambda command: None,
    ) -> None:
        self._ready = ready
        self._stands = stands
        self._withhold = withhold
        self._queue: list[_Due] = []
        self._prepared: _Prepared | None = None
        self._wanted: dict[Mover, Velocity] = {}  # the velocity of each, as if its robot did not stand
        self._zeros_left: dict[Mover, int] = {}  # zeros still to send to the movers of a muted robot
        self._limbs: dict[str, dict[Mover, None]] = {}  # the body parts of each robot that have had a setpoint
        self._next: dict[Mover, float] = {}  # the time of the next change of each body part
        self._stops = False  # True while it stops robots
        self.repeats = Repeats()
        """The movers that hold a velocity."""

    @property
    def due(self) -> float:
        """The time at which the next change is due."""
        return self._queue[0].at if self._queue else math.inf

    def next_of_limbs(self, robot: str, at: float) -> float:
        """The time of the next change of a robot's body parts after a time; that time if the robot stops or stands."""
        if self._stops or self._stands(robot):
            return at
        times = (self._next.get(mover, math.inf) for mover in self._limbs.get(robot, ()))
        return min((time for time in times if time > at), default=math.inf)

    def movers(self, robots: Iterable[str]) -> list[Mover]:
        """The bases of robots, and their body parts that have had a setpoint."""
        return [mover for robot in robots for mover in (Mover(robot), *self._limbs.get(robot, ()))]

    def restart(self, robots: Collection[str], performed: float) -> None:
        """Start performance time over, with these robots. Those that left before still get their last zeros."""
        left = [due for due in self._queue if due.mover.robot not in robots]
        self._limbs = {due.mover.robot: self._limbs[due.mover.robot] for due in left if due.mover.part}
        self._queue = [due._replace(at=due.at - performed, offset=due.offset - performed) for due in left]
        heapify(self._queue)
        self._next = {due.mover: due.at for due in self._queue if due.mover.part}
        self._wanted = {}
        self.repeats.restart()

    def begin(self, robots: Collection[str]) -> None:
        """Get ready for new setpoints of these robots."""
        movers = self.movers(robots)
        self.drop(movers)
        for mover in movers:
            self._zeros_left[mover] = LAST_ZEROS if self._stands(mover.robot) else 0

    def drop(self, movers: Collection[Mover]) -> None:
        """Drop the setpoints of movers. Those that have left the score still get their zeros."""
        self.drop_changes(movers)
        for mover in movers:
            self.repeats.release(mover)

    def drop_changes(self, movers: Collection[Mover]) -> None:
        """Drop the setpoints of movers, which hold their velocities."""
        self.forget_prepared()
        self._queue = [due for due in self._queue if due.mover not in movers]
        heapify(self._queue)
        for mover in movers:
            self._next.pop(mover, None)

    def add(self, mover: Mover, planned: Iterator[Setpoint], offset: float) -> None:
        """Send a mover these setpoints, whose times count from `offset`."""
        if following := next(planned, None):
            at, velocity, held = following
            self._push(_Due(at + offset, mover, velocity, held, planned, offset))

    def begin_open(self, mover: Mover, at: float) -> None:
        """Begin an open part, and always send its first velocity."""
        self._wanted.pop(mover, None)
        self.add_open(mover, at)

    def add_open(self, mover: Mover, at: float) -> None:
        """Perform a mover's open part at this time."""
        self._push(_Due(at, mover, None, True, iter(()), 0.0))

    def hold(self, mover: Mover, velocity: Velocity, rate: float, at: float) -> None:
        """Send a mover a velocity if it is a new one, and repeat it at `rate` Hz."""
        if velocity != self._wanted.get(mover):
            self._send([MoverCommand(mover, velocity, at)])
            self.repeats.hold(mover, rate, at)

    def prepare(self) -> None:
        """Get the changes that are due next ready to be sent, unless they depend on senses, or on robots that stand."""
        if self._prepared or not self._queue:
            return
        due = sorted(each for each in self._queue if each.at == self.due)
        commands = [MoverCommand(each.mover, each.velocity, each.at) for each in due if each.velocity is not None]
        if len(commands) == len(due) and not any(self._stands(each.mover.robot) for each in due):
            self._prepared = _Prepared(self.due, commands, self._ready(commands))

    def forget_prepared(self) -> None:
        """Forget what is ready, because it may no longer be what robots must be sent."""
        self._prepared = None

    def send_changes(self, until: float, parts: Mapping[str, Part], perform: Callable[[Mover, float], None]) -> None:
        """Send the changes that are prepared if they are due by then, otherwise all changes until then, and only then
        compute the next ones. `perform` performs open parts."""
        prepared, self._prepared = self._prepared, None
        if prepared and prepared.at <= until:
            try:
                prepared.send()  # before anything else
            finally:
                self._wanted.update((mover, velocity) for mover, velocity, _ in prepared.commands)
                self._follow(_taken(self._queue, prepared.at), parts)
            return
        due, commands = _taken(self._queue, until), list[MoverCommand]()
        try:
            for each in due:
                if each.velocity is not None:
                    commands.append(MoverCommand(each.mover, each.velocity, each.at))
                    continue
                self._send(commands)  # in order: a simulator takes nothing from an earlier time later
                commands = []
                perform(each.mover, each.at)
            self._send(commands)
        finally:
            self._follow(due, parts)

    def send_repeats(self, performed: float) -> None:
        """Send the repeats of one slot if they are due."""
        if self.repeats.due <= performed:
            movers = self.repeats.take(performed)
            self._send([MoverCommand(mover, self._wanted[mover], performed) for mover in movers])

    def resend(self, robot: str, at: float) -> None:
        """Send a robot its current velocity now that it has begun to stand, or no longer has to."""
        self.silence([robot])
        self._send([MoverCommand(mover, self._wanted.get(mover, STILL), at) for mover in self.movers([robot])])

    def silence(self, robots: Collection[str]) -> None:
        """Send robots that have begun to stand their last zeros instead of their setpoints."""
        self.forget_prepared()
        self._zeros_left.update(dict.fromkeys(self.movers(robots), LAST_ZEROS))

    def stop(self, parts: Mapping[str, Part], performed: float) -> None:
        """Stop robots at once. If one can't be stopped, the others still are before that is raised."""
        movers, self._stops = self.movers(parts), True
        try:
            self.still(movers, performed)  # before anything else
        finally:
            self._stops = False
            self.drop(movers)
            for mover in movers:
                _, *rest = zeros(performed, 1 / parts[mover.robot].profile.command_rate)
                self.add(mover, iter(rest), 0.0)

    def leave_topics(self, before: Mapping[str, Part], after: Mapping[str, Part], performed: float) -> None:
        """Stop robots at once whose topic or message type changes, and those that lose their topic to another one."""
        taken = {part.topic for part in after.values()}
        for robot, part in before.items():
            later = after.get(robot)
            moved = later and (later.topic, later.profile.message) != (part.topic, part.profile.message)
            if moved or (not later and part.topic in taken):
                for _ in range(LAST_ZEROS):
                    self.still(self.movers([robot]), performed)
            elif later and later.profile.body != part.profile.body:
                self.still(self.movers([robot])[1:], performed)

    def still(self, movers: Iterable[Mover], performed: float) -> None:
        """Send movers a zero at once."""
        self._ready([MoverCommand(mover, STILL, performed) for mover in movers])()

    def stop_leaving(self, before: Mapping[str, Part], after: Mapping[str, Part], performed: float) -> None:
        """Send robots that have left their last zeros, unless another robot has their topic now."""
        taken = {part.topic for part in after.values()}
        for robot in before.keys() - after.keys():
            part = before[robot]
            if part.topic not in taken:
                for mover in self.movers([robot]):
                    self.add(mover, zeros(0.0, 1 / part.profile.command_rate), performed)

    def _follow(self, due: Iterable[_Due], parts: Mapping[str, Part]) -> None:
        """Schedule what follows changes, also if a robot couldn't be reached: it must not come first again and hold up
        the zeros of the others."""
        for at, mover, velocity, held, rest, offset in due:
            if velocity is None:
                continue
            if held:
                self.repeats.hold(mover, parts[mover.robot].profile.command_rate, at)
            else:
                self.repeats.release(mover)
            self.add(mover, rest, offset)

    def _push(self, due: _Due) -> None:
        self.forget_prepared()
        if due.mover.part:
            self._limbs.setdefault(due.mover.robot, {})[due.mover] = None
            self._next[due.mover] = due.at
        heappush(self._queue, due)

    def _send(self, commands: Iterable[MoverCommand]) -> None:
        sent = list[MoverCommand]()
        for command in commands:
            mover = command.mover
            self._wanted[mover] = command.velocity
            if not self._stands(mover.robot):
                sent.append(command)
                continue
            if left := self._zeros_left.get(mover, 0):
                self._zeros_left[mover] = left - 1
                sent.append(command._replace(velocity=STILL))
            self._withhold(command)
        if sent:
            self._ready(sent)()


class _Prepared(NamedTuple):
    """The commands that are due next, at a performance time, and a function that sends them."""

    at: float
    commands: Sequence[MoverCommand]
    send: Callable[[], None]


class _Due(NamedTuple):
    """A mover's next setpoint at a performance time, and the rest of them, whose times count from `offset`.

    A setpoint without a velocity belongs to an open part: it depends on joints and senses at the time when it is due.
    """

    at: float
    mover: Mover
    velocity: Velocity | None
    held: bool
    rest: Iterator[Setpoint]
    offset: float


def _taken(queue: list[_Due], until: float) -> list[_Due]:
    """Take the changes until then from a queue."""
    due = []
    while queue and queue[0].at <= until:
        due.append(heappop(queue))
    return due


def setpoints(profile: Profile, movement: Movement, tempo: Fraction, start: Exact = 0) -> Iterator[Setpoint]:
    """Yield the setpoints of a movement from its beat `start` on, with times from there: each change, then zeros."""
    period = 1 / profile.command_rate
    seconds = 60 / tempo
    shortest = SHORTEST / seconds
    duration = movement.duration
    if start >= duration:
        yield from zeros(0.0, period)
        return
    moments = walk(movement, start, merge=True)
    while moment := next(moments, None):
        if moment.duration < shortest and (moment.start > start or not start):
            end = moment.start + shortest
            if end >= duration:
                end = Fraction(duration)
            moments = walk(movement, end, merge=True)
        # Compute each time from the start instead of adding up, so no error grows however long it plays.
        yield Setpoint(float((moment.start - start) * seconds), twist(moment.velocity, profile, tempo), True)
    yield from zeros(float((duration - start) * seconds), period)


def zeros(start: float, period: float) -> Iterator[Setpoint]:
    """Return the short burst of zeros that stops a robot."""
    return (Setpoint(start + count * period, STILL, False) for count in range(LAST_ZEROS))
