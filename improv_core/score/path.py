"""The path of a movement: its length, its turns, and its end. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import islice
from typing import Generic, NamedTuple, Protocol, TypeVar

from improv_core.score.algebra import Parallel, Repeat, reverse
from improv_core.score.budget import Budget, TooLongError
from improv_core.score.motion import Pose
from improv_core.score.movement import (
    ENDLESS,
    NOTHING_AROUND,
    SAME,
    Duration,
    Exact,
    Factors,
    InTurn,
    Movement,
    Piecewise,
    Through,
    Velocity,
    Visit,
)
from improv_core.score.profiles import Profile
from improv_core.score.projection import Reach
from improv_core.score.reactions import Reaction
from improv_core.score.score import Part, twist
from improv_core.score.throws import ROBOTS, Dice, dice_of
from improv_core.score.traversal import inner_first
from improv_core.score.walk import walk

MAX_WALKED = 2_000
"""Parallel voices are walked to measure them. If they have more moments than this, the result is unknown."""
MAX_MEASURED_THROWS = 100_000
"""The most throws to examine: the turns of a repeat with dice differ, so they can't be multiplied."""
MAX_MEASURED_LIVE = 10_000
"""The same limit for a pose, which is computed while robots play."""
MAX_VELOCITIES = 1_000
"""The number of velocities in meters that are kept: most are those of a few words."""
VISITS_PER_THROW = 5
"""The number of parts that may be visited for each of these throws."""
A_BEAT_A_SECOND = Fraction(60)
"""A tempo at which beats are seconds. A path does not depend on the tempo."""


class PlayedPart(NamedTuple):
    """A part of a movement as it plays: with its velocities multiplied, perhaps backward, and with its dice if any."""

    movement: Movement
    gain: Factors
    backward: bool
    dice: Dice | None

    @classmethod
    def first(cls, movement: Movement) -> PlayedPart:
        return cls(movement, SAME, False, dice_of(ROBOTS) if movement.dice else None)

    def to(self, visit: Visit) -> PlayedPart:
        """Return the part that plays in place of this one."""
        part, _, backward, dice = visit
        around = self.movement.within(NOTHING_AROUND)
        gain = self.gain if around is NOTHING_AROUND else self.gain.times(around.gain)
        return PlayedPart(part, gain, backward, dice if part.dice else None)

    @property
    def is_walked(self) -> bool:
        """True if it is measured as a whole."""
        return self.movement.uniform is not None or isinstance(self.movement, (Parallel, Reach))


class Extent(NamedTuple):
    """The length of a path in meters, and its total turn in radians, positive to the left."""

    length: float
    turn: float

    def then(self, other: Extent) -> Extent:
        return Extent(self.length + other.length, self.turn + other.turn)


def extent(movement: Movement, profile: Profile) -> Extent | None:
    """Return a movement's extent for a robot; None if it is endless, or like `pose_at`."""

    def stretch(velocity: Velocity, beats: float) -> Extent:
        moving = twist(velocity, profile, A_BEAT_A_SECOND)
        return Extent(math.hypot(moving.x, moving.y, moving.z) * beats, moving.yaw * beats)

    outcomes = Outcomes(Extent(0.0, 0.0), stretch)
    try:
        whole = Budget(MAX_MEASURED_THROWS * VISITS_PER_THROW)
        return None if movement.duration == ENDLESS else outcomes.until(movement, movement.duration, whole)
    except TooLongError:
        return None


def pose_at(part: Part, beat: Exact, most_throws: int = MAX_MEASURED_LIVE) -> Pose | None:
    """A robot's ideal pose at a beat of the performance; None if voices are too long to walk, or throws too many.

    Repeats without dice are multiplied, not walked: the billionth repetition costs no more than the second.
    """
    try:
        return Paths().pose(part, beat, Budget(most_throws * VISITS_PER_THROW))
    except TooLongError:
        return None


class Paths:
    """The ideal poses of robots. Each part of a movement is visited once, even if many ask for it."""

    def __init__(self) -> None:
        self._outcomes: dict[Profile, Outcomes[_Flight]] = {}
        self._movements: dict[int, Movement] = {}  # kept alive as long as their outcomes

    def pose(self, part: Part, beat: Exact, budget: Budget) -> Pose:
        """Return a robot's pose at a beat of the performance. Raises TooLongError if the budget is too small."""
        movement, start = part.movement, part.entered or part.start
        passed = min(max(beat - part.begins, 0), movement.duration)
        self._movements[id(movement)] = movement
        if part.profile not in self._outcomes:
            self._outcomes[part.profile] = _flights(part.profile)
        return self._outcomes[part.profile].until(movement, passed, budget).landing(start)


def displacement(movement: Movement, beats: Duration, profile: Profile, most_throws: int) -> Pose | None:
    """Return the displacement of a robot in the first beats of a movement if no ground stops it, as a pose relative to
    its start; None like `pose_at`."""
    try:
        return _flights(profile).until(movement, beats, Budget(most_throws * VISITS_PER_THROW)).moved
    except TooLongError:
        return None


class _Chained(Protocol):
    """The effect of a stretch of a movement, whatever was before it."""

    def then(self: M, other: M, /) -> M:
        """The effect of both, one after the other."""
        ...


M = TypeVar("M", bound=_Chained)


class _Flight(NamedTuple):
    """The pose that a robot reaches if no ground stops it, and its lowest height on the way, both from its start."""

    moved: Pose
    lowest: float

    def then(self, other: _Flight) -> _Flight:
        return _Flight(self.moved.then(other.moved), min(self.lowest, self.moved.z + other.lowest))

    def landing(self, start: Pose) -> Pose:
        """Return the pose after the flight from a pose, if the ground stops the robot: higher by what it would sink."""
        end = start.then(self.moved)
        return replace(end, z=end.z - min(start.z + self.lowest, 0.0))


def _flights(profile: Profile) -> Outcomes[_Flight]:
    twists = lru_cache(MAX_VELOCITIES)(lambda velocity: twist(velocity, profile, A_BEAT_A_SECOND))

    def held(velocity: Velocity, beats: float) -> _Flight:
        pose = Pose().after(twists(velocity), beats)
        return _Flight(pose, min(pose.z, 0.0))

    return Outcomes(_Flight(Pose(), 0.0), held)


class Outcomes(Generic[M]):
    """The effects of movements, from those of velocities in numbers of beats. Repeats without dice are multiplied."""

    def __init__(self, nothing: M, held: Callable[[Velocity, float], M]) -> None:
        self._nothing, self._held = nothing, held
        self._known: dict[tuple[int, Factors, bool], M] = {}  # by movements that live as long as this
        self._budget = Budget(0)

    def until(self, movement: Movement, beats: Duration, budget: Budget) -> M:
        """Return the effect of the first beats of a movement.

        Raises TooLongError if that visits more parts than the budget has.
        """
        self._budget = budget
        return self.first_beats(PlayedPart.first(movement), beats)

    def first_beats(self, played: PlayedPart, beats: Duration) -> M:
        done = self._nothing
        while beats < played.movement.duration and not played.is_walked:
            before, played, beats = _split(played, beats, self._budget)
            for each, times in before:
                done = done.then(self._times(self._whole(each), times))
        if beats < played.movement.duration:
            return done.then(self.walked(played, beats))
        return done.then(self._whole(played))

    def _whole(self, played: PlayedPart) -> M:
        if not played.dice:
            return self._without_dice(played)
        done = self._nothing
        for each in _decided(played, self._budget):
            done = done.then(self.walked(each, each.movement.duration) if each.dice else self._without_dice(each))
        return done

    def _without_dice(self, played: PlayedPart) -> M:
        if self._is_known(played):
            return self._known[_key(played)]
        for now in inner_first(played, self._unknown_inside, _key):
            self._budget.spend()
            done = self._nothing
            for each in _inside(now):
                done = done.then(self._known[_key(each)])
            if isinstance(now.movement, Repeat):
                done = self._times(done, now.movement.times or 0)
            self._known[_key(now)] = done
        return self._known[_key(played)]

    def _unknown_inside(self, played: PlayedPart) -> Iterable[PlayedPart]:
        return [each for each in _inside(played) if not self._is_known(each)]

    def _is_known(self, played: PlayedPart) -> bool:
        """Return whether the effect of a part is known. If the part is walked, which is usually one word, this computes
        it."""
        key = _key(played)
        if key in self._known:
            return True
        if played.is_walked:
            self._budget.spend()
            self._known[key] = self.walked(played, played.movement.duration)
        return played.is_walked

    def walked(self, played: PlayedPart, until: Duration) -> M:
        """Return the effect of the first `until` beats of a part that is walked."""
        if played.movement.uniform is not None:
            return self._held(played.movement.uniform.times(played.gain), float(until))
        period = _period(played.movement)
        if period and until > period:
            turns, rest = divmod(until, period)
            once, last = (self.walked(played, beats) for beats in (period, rest))
            return self._times(once, int(turns)).then(last)
        movement = reverse(played.movement) if played.backward else played.movement
        own = None if played.dice else Budget(MAX_WALKED)
        done = self._nothing
        for moment in walk(movement, merge=True, dice=played.dice):
            left = until - moment.start
            if left <= 0:
                break
            self._budget.spend()
            if own:
                own.spend()
            done = done.then(self._held(moment.velocity.times(played.gain), float(min(moment.duration, left))))
        return done

    def _times(self, once: M, times: int) -> M:
        """Return the effect of doing it so often, computed by repeated squaring."""
        done = self._nothing
        while times:
            if times % 2:
                done = done.then(once)
            once, times = once.then(once), times // 2
        return done


def _split(
    played: PlayedPart, until: Duration, budget: Budget
) -> tuple[Iterable[tuple[PlayedPart, int]], PlayedPart, Duration]:
    """Return the inner parts that finish within `until` beats, and how often; and the next one, and its beats."""
    part, _, backward, dice = played
    at = part.duration - until if backward else until
    if isinstance(part, Through):
        visit = part.inner(at, backward, dice)
        return (), played.to(visit), visit.part.duration - visit.at if visit.backward else visit.at
    if isinstance(part, Repeat) and part.body.duration != ENDLESS:
        turns = int(until // part.body.duration)
        inner = played.to(next(part.visits(at, backward, dice)))
        done = [(inner, turns)]
        if dice:
            budget.allow(turns * max(part.body.bounds.throws * VISITS_PER_THROW, 1))
            done = [(each, 1) for each in islice(_inside(played), turns)]
        return done, inner, until % part.body.duration
    done = []
    for inner in _inside(played):
        if until < inner.movement.duration:
            break
        done.append((inner, 1))
        until -= inner.movement.duration
    budget.allow(sum(each.movement.bounds.throws for each, _ in done) * VISITS_PER_THROW)
    return done, inner, until


def _key(played: PlayedPart) -> tuple[int, Factors, bool]:
    return id(played.movement), played.gain, played.backward


def _decided(played: PlayedPart, budget: Budget) -> Iterator[PlayedPart]:
    """Yield a part as a series of parts without dice, and of voices with dice."""
    stack = [iter((played,))]
    while stack:
        each = next(stack[-1], None)
        if each is None:
            stack.pop()
            continue
        budget.spend()  # also for what is known: a repeat may have it billions of times
        if each.dice is None or each.is_walked:
            yield each
        elif each.movement.duration:  # an endless repeat of nothing is over at once
            budget.allow(each.movement.bounds.throws * VISITS_PER_THROW)
            stack.append(_inside(each))


def _inside(played: PlayedPart) -> Iterator[PlayedPart]:
    """Yield the inner parts in the order they play; the body of a repeat without dice only once."""
    part, gain, backward, dice = played
    at = part.duration if backward else 0
    if isinstance(part, Through):
        yield played.to(part.inner(at, backward, dice))
    elif isinstance(part, Repeat) and not dice:
        yield PlayedPart(part.body, gain, backward, None)
    else:
        assert isinstance(part, InTurn)
        for each, _, _, own in part.visits(at, backward, dice):
            yield PlayedPart(each, gain, backward, own if each.dice else None)


def _period(movement: Movement) -> Exact | None:
    """Return the beats after which all parallel voices are back at their start; None if that never happens.

    0 if the velocity never changes. The period is the same backward.
    """
    if movement.dice:
        return None
    rate = Fraction(1)
    while movement.uniform is None and isinstance(movement, Through) and not isinstance(movement, Piecewise):
        rate *= movement.within(NOTHING_AROUND).rate
        movement = movement.assumed if isinstance(movement, Reaction) else movement.parts[0]
    if movement.uniform is not None:
        return 0
    if isinstance(movement, Repeat) and movement.body.duration != ENDLESS:
        return Fraction(movement.body.duration) / rate
    if not isinstance(movement, Parallel):
        return None
    common = Fraction(0)
    for voice in movement.items:
        period = _period(voice)
        if period is None:
            return None
        common = common_multiple(common, Fraction(period)) if period else common
    return common / rate


def common_multiple(one: Fraction, other: Fraction) -> Fraction:
    """Return the least common multiple; 0 is ignored."""
    if not one:
        return other
    return Fraction(math.lcm(one.numerator, other.numerator), math.gcd(one.denominator, other.denominator))
