"""Finds the robots that meet each other or hit something, before any of them moves. Standard library only.

Robots are discs that move exactly as the score says: the first beats of all pairs are checked, then the next ones. Only
pairs whose boxes touch within a few beats are examined more closely.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.score.cycles import common_cycle
from improv_core.score.encounters import RoomResults, first_encounter, follow_all
from improv_core.score.motion import Pose
from improv_core.score.score import Part, Score
from improv_core.score.strokes import pictured
from improv_core.score.trajectories import BLOCK, Trajectory

LAST_BEAT = 1_000
"""The most beats that are checked."""


class Meeting(NamedTuple):
    """The first time that two robots come too near: its beat, their poses then, and the least distance of their centers
    until they are apart again, in meters. They meet `more` times after that."""

    robots: tuple[str, str]
    beat: float
    poses: tuple[Pose, Pose]
    distance: float
    more: int


class Hit(NamedTuple):
    """The first time that a robot comes too near to a thing in the world, such as `wall 1`, or to the edge."""

    robot: str
    thing: str
    beat: float
    pose: Pose


@dataclass(frozen=True, slots=True)
class RoomCheck:
    """The results from beat `start` to beat `end`, in the order of the beats. If `is_all`, nothing else comes after
    that: all robots have ended, or repeat themselves."""

    start: float
    end: float
    is_all: bool
    meetings: Sequence[Meeting]
    hits: Sequence[Hit]
    known: RoomResults


def check_room(
    score: Score, start: float = 0, before: RoomResults | None = None, most_work: int | None = None
) -> RoomCheck:
    """Check the room from a beat on, as if no sense ever holds and an endless movement with `until` ends as it is
    drawn.

    That beat is a multiple of 1/1024, so that whole beats can be added exactly. `before` has the results of an earlier
    check: only pairs with a robot that moves otherwise now are checked again. With less work, fewer beats are checked.
    """
    score = pictured(score)
    known, kept = _still_known(score, start, before or RoomResults())
    flies = any(part.movement.bounds.peak.z for part in score.parts.values())
    if len(score.parts) < 2 and not (flies or score.world.has_obstacles):
        return RoomCheck(start, start, True, (), (), known)
    end, is_all = _end(known.trajectories.values(), start)
    given_up = follow_all(score, known, kept, start, max(math.ceil((end - start) / BLOCK), 1), most_work)
    if given_up is None:
        return RoomCheck(start, end, is_all, _meetings(known, start, end), _hits(known, start, end), known)
    end = min(end, given_up)
    trajectories = RoomResults(known.trajectories, world=known.world)  # the other results end in the middle of a block
    return RoomCheck(start, end, False, _meetings(known, start, end), _hits(known, start, end), trajectories)


def would_meet(score: Score, robots: tuple[str, str], known: RoomResults) -> bool:
    """Return whether two robots ever come too near to each other, as far as that is checked. No others are examined."""
    parts = pictured(score).parts
    one, other = (_trajectory(parts[name], 0, known) for name in robots)
    end, _ = _end((one, other), 0)
    return first_encounter(one, other, score.world.margin, max(end, 1)) is not None


def _trajectory(part: Part, start: float, known: RoomResults) -> Trajectory:
    """Return the trajectory of a part: the known one, if that still holds."""
    old = known.trajectories.get(part.robot)
    return old if old and old.is_of(part, start) else Trajectory(part, start)


def _end(trajectories: Iterable[Trajectory], start: float) -> tuple[float, bool]:
    """Return the beat up to which robots are followed, and whether nothing else comes after it."""
    repeats = common_cycle(each.cycle for each in trajectories)
    latest = max(repeats.begins, start) + repeats.beats if repeats else math.inf
    return max(float(min(latest, start + LAST_BEAT)), start), latest <= start + LAST_BEAT


def _meetings(known: RoomResults, start: float, end: float) -> list[Meeting]:
    order = {name: number for number, name in enumerate(known.trajectories)}
    found = []
    for pair, each in known.pairs.items():
        if beats := [beat for beat in each.beats if beat < end or beat == start]:
            one, other = (known.pose(robot, beats[0]) for robot in pair)
            found.append(Meeting(pair, beats[0], (one, other), each.least, len(beats) - 1))
    return sorted(found, key=lambda meeting: (meeting.beat, *(order[name] for name in meeting.robots)))


def _hits(known: RoomResults, start: float, end: float) -> list[Hit]:
    found = [
        Hit(robot, thing, beat, known.pose(robot, beat))
        for robot, things in known.hits.items()
        for thing, beat in things.items()
        if beat < end or beat == start
    ]
    return sorted(found, key=lambda hit: hit.beat)


def _still_known(score: Score, start: float, before: RoomResults) -> tuple[RoomResults, Collection[str]]:
    """Return the results that still hold for a score, and the robots that they are about."""
    known = RoomResults(world=score.world)
    for name, part in score.parts.items():
        known.trajectories[name] = _trajectory(part, start, before)
    if score.world != before.world:
        return known, ()
    kept = {name for name, each in known.trajectories.items() if each is before.trajectories.get(name)}
    known.blocks = before.blocks
    order = {name: number for number, name in enumerate(score.parts)}
    for (one, other), each in before.pairs.items():
        if one in kept and other in kept:
            pair = (one, other) if order[one] < order[other] else (other, one)
            known.pairs[pair] = replace(each, beats=[*each.beats])
    known.hits = {name: {**each} for name, each in before.hits.items() if name in kept}
    return known, kept
