"""Follows all robots of a score at once and notes those that come too near to something. Standard library only.

Only pairs whose boxes touch within a block of beats, and then within a beat, are examined more closely.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from improv_core.score.approach import TOLERANCE, Bound, Encounters, follow, sinks, touches
from improv_core.score.budget import Budget, TooLongError
from improv_core.score.motion import Pose
from improv_core.score.obstacles import GROUND, Obstacle, obstacles
from improv_core.score.score import Score
from improv_core.score.trajectories import BLOCK, Block, Trajectory, Volume
from improv_core.score.world import EMPTY, World

MAX_WORK = 2_000_000
"""The most segments, pairs, and moments to examine, which takes a few seconds. Then fewer beats are checked."""


@dataclass(slots=True)
class RoomResults:
    """Results about the first blocks, for the next check: the trajectories of robots, and those that come too near.

    A robot's hits are the beats at which it first comes too near to each thing.
    """

    trajectories: dict[str, Trajectory] = field(default_factory=dict)
    pairs: dict[tuple[str, str], Encounters] = field(default_factory=dict)
    hits: dict[str, dict[str, float]] = field(default_factory=dict)
    world: World = EMPTY
    blocks: int = 0

    def pose(self, robot: str, beat: float) -> Pose:
        return self.trajectories[robot].pose(beat)


def follow_all(
    score: Score, known: RoomResults, kept: Collection[str], start: float, blocks: int, most_work: int | None
) -> float | None:
    """Add the trajectories and encounters of all robots in this many blocks to what is known. Robots in `kept` keep
    theirs. Return the beat at which that became too much work; None if it didn't."""
    half = score.world.margin / 2  # the other half is around the robots
    things = [each._replace(box=each.box.larger(half, 0)) for each in obstacles(score.world)]
    work = Budget(most_work or MAX_WORK)
    for place in range(max(blocks, known.blocks)):
        begin = start + place * BLOCK
        is_known = place < known.blocks
        try:
            here = [
                _here(score, number, name, known, place, is_known and name in kept, work)
                for number, name in enumerate(score.parts)
            ]
            for one, other in _near(here, work):
                _follow_pair(one, other, begin, score.world.margin, known, work)
            for each in here:
                if not each.is_known:
                    _follow_among(each, things, begin, score.world.margin, known, work)
        except TooLongError:
            return begin
    known.blocks = max(blocks, known.blocks)
    return None


def first_encounter(one: Trajectory, other: Trajectory, margin: float, end: float) -> float | None:
    """Return the beat at which two robots first come too near, before a beat; None if they don't."""
    found, bound = Encounters(), _bound(one.part.profile.radius, other.part.profile.radius, margin)
    work = Budget(MAX_WORK)
    for number in range(math.ceil((end - one.start) / BLOCK)):
        mine, others = one.block(number), other.block(number)
        if not (mine and others):
            break
        if mine.box.is_within(others.box, bound.near):
            _follow_blocks(mine, others, one.start + number * BLOCK, bound, found, work)
            if found.beats:
                return found.beats[0] if found.beats[0] < end else None
    return None


def _follow_blocks(one: Block, other: Block, begin: float, bound: Bound, found: Encounters, work: Budget) -> None:
    for number, (mine, others) in enumerate(zip(one.beats, other.beats, strict=True)):
        if mine.box.is_within(others.box, bound.near):
            follow(mine, others, begin + number, bound, found, work)


def _bound(one: float, other: float, margin: float) -> Bound:
    return Bound(one + other + margin, one + other)


class _Here(NamedTuple):
    """A robot during a block, and a box around everything that its disc and half the margin cover."""

    number: int
    name: str
    radius: float
    block: Block
    box: Volume
    is_known: bool


def _here(score: Score, number: int, name: str, known: RoomResults, place: int, is_known: bool, work: Budget) -> _Here:
    block = known.trajectories[name].block(place)
    if block is None:
        raise TooLongError
    work.spend(block.segments)
    radius = score.parts[name].profile.radius
    return _Here(number, name, radius, block, block.box.larger(radius + score.world.margin / 2, radius), is_known)


def _near(here: Sequence[_Here], work: Budget) -> Iterator[tuple[_Here, _Here]]:
    """Yield the pairs whose boxes touch, in a sweep along x. Each pair is in the order of the robots."""
    reached: list[_Here] = []
    for each in sorted(here, key=lambda each: each.box.x0):
        reached = [other for other in reached if other.box.x1 >= each.box.x0]
        work.spend(len(reached))
        for other in reached:
            if not (each.is_known and other.is_known) and each.box.touches(other.box):
                yield (each, other) if each.number < other.number else (other, each)
        reached.append(each)


def _follow_pair(one: _Here, other: _Here, begin: float, margin: float, known: RoomResults, work: Budget) -> None:
    bound = _bound(one.radius, other.radius, margin)
    found = known.pairs.get((one.name, other.name)) or Encounters()
    work.spend(BLOCK)
    _follow_blocks(one.block, other.block, begin, bound, found, work)
    if found.beats:
        known.pairs[one.name, other.name] = found


def _follow_among(
    robot: _Here, things: Sequence[Obstacle], begin: float, margin: float, known: RoomResults, work: Budget
) -> None:
    hits = known.hits.setdefault(robot.name, {})
    if robot.block.box.z0 < -TOLERANCE and hits.get(GROUND, math.inf) >= begin:
        work.spend(BLOCK)
        below = (sinks(beat, begin + number) for number, beat in enumerate(robot.block.beats))
        if (first := next((at for at in below if at is not None), None)) is not None:
            hits[GROUND] = first
    work.spend(len(things))
    for thing in things:
        if hits.get(thing.name, math.inf) < begin or not robot.box.touches(thing.box):
            continue
        work.spend(BLOCK)
        for number, beat in enumerate(robot.block.beats):
            if beat.box.is_within(thing.box, robot.radius + margin):
                touch = touches(beat, begin + number, robot.radius + margin, thing.distance, work)
                if touch is not None:
                    hits[thing.name] = min(touch, hits.get(thing.name, touch))
                    break
