"""Places of a robot at each beat: lines and arcs, with boxes around them. Times are beats. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import count
from typing import NamedTuple

from improv_core.score.cycles import Cycle, closed_cycle, cycle
from improv_core.score.equality import same
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Movement, Velocity
from improv_core.score.path import A_BEAT_A_SECOND
from improv_core.score.score import Part, twist
from improv_core.score.walk import walk
from improv_core.slices import checkpoint

BLOCK = 16
"""The number of beats that are computed at a time. Robots that are far apart for a whole block need no closer look."""
MAX_SEGMENTS = 4_000
"""The most segments of a block. A robot with more is not followed any further."""


class Segment(NamedTuple):
    """A line or an arc from beat `start` to `end`: the place at its start, and its velocity there in the world, in
    meters per beat, which turns by `turn` radians per beat. `heading` turns by `yaw`, even if the robot stays."""

    start: float
    end: float
    x: float
    y: float
    z: float
    along_x: float
    along_y: float
    along_z: float
    turn: float
    heading: float
    yaw: float


class Volume(NamedTuple):
    """Everything between these coordinates."""

    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float

    def larger(self, sideways: float, up: float) -> Volume:
        """Return the box with so much space around it."""
        x0, y0, z0, x1, y1, z1 = self
        return Volume(x0 - sideways, y0 - sideways, z0 - up, x1 + sideways, y1 + sideways, z1 + up)

    def touches(self, other: Volume) -> bool:
        return (
            self.x0 <= other.x1
            and other.x0 <= self.x1
            and self.y0 <= other.y1
            and other.y0 <= self.y1
            and self.z0 <= other.z1
            and other.z0 <= self.z1
        )

    def is_within(self, other: Volume, far: float) -> bool:
        """Return whether the boxes, seen from above, are so near each other."""
        return (
            self.x0 <= other.x1 + far
            and other.x0 <= self.x1 + far
            and self.y0 <= other.y1 + far
            and other.y0 <= self.y1 + far
        )


class Beat(NamedTuple):
    """The segments of a beat, the first and the last of which may reach beyond it, and a box around the places."""

    segments: Sequence[Segment]
    box: Volume


class Block(NamedTuple):
    """Some beats in a row, a box around them, and the number of their segments."""

    beats: Sequence[Beat]
    box: Volume
    segments: int


def moving_at(segment: Segment, beat: float) -> tuple[float, float, float, float]:
    """Return the place along x and y at a beat of a segment, and the velocity in the world there."""
    passed, turn = beat - segment.start, segment.turn
    along_x, along_y = segment.along_x, segment.along_y
    if not turn:
        return segment.x + along_x * passed, segment.y + along_y * passed, along_x, along_y
    angle = turn * passed
    sin, cos, half = math.sin(angle), math.cos(angle), math.sin(angle / 2)
    # The displacement is that of `Pose.after`; 2 sin²(a/2) is 1 - cos a without cancellation.
    along, across = sin / turn, 2 * half * half / turn
    return (
        segment.x + along_x * along - along_y * across,
        segment.y + along_x * across + along_y * along,
        along_x * cos - along_y * sin,
        along_x * sin + along_y * cos,
    )


class Trajectory:
    """The ideal trajectory of a robot from beat `start` on, computed block by block, as far as it is needed."""

    def __init__(self, part: Part, start: float = 0) -> None:
        self.part = part
        self.start = start
        self._blocks: list[Block] = []
        self._segments = _segments(part, start)
        self._now = next(self._segments)
        self._is_lost = False

    def is_of(self, part: Part, start: float) -> bool:
        """Return whether another part would lead a robot along the same trajectory from a beat on."""
        mine = self.part
        return (
            not self._is_lost
            and self.start == start
            and (mine.start, mine.entered, mine.begins) == (part.start, part.entered, part.begins)
            and _body(mine) == _body(part)
            and same(mine.movement, part.movement)
        )

    @cached_property
    def cycle(self) -> Cycle | None:
        """The cycle in which the robot repeats itself."""
        return closed_cycle(self.part)

    def block(self, number: int) -> Block | None:
        """Return a block, counted from 0; None if there are too many segments to get there."""
        while number >= len(self._blocks) and not self._is_lost:
            self._add()
        return self._blocks[number] if number < len(self._blocks) else None

    def pose(self, beat: float) -> Pose:
        """Return the robot's pose at a beat that has been computed."""
        number, within = divmod(math.floor(beat - self.start), BLOCK)
        segments = self._blocks[number].beats[within].segments
        segment = next((each for each in segments if each.end > beat), segments[-1])
        x, y, _, _ = moving_at(segment, beat)
        passed = beat - segment.start
        return Pose(x, y, segment.z + segment.along_z * passed, segment.heading + segment.yaw * passed)

    def _add(self) -> None:
        """Add a block. If that is too long or is interrupted for good, nothing more can be added."""
        self._is_lost = True
        first, beats, count = self.start + BLOCK * len(self._blocks), list[Beat](), 0
        for number in range(BLOCK):
            checkpoint()
            begin = first + number
            here = [self._now]
            while self._now.end <= begin + 1:
                self._now = next(self._segments)
                if self._now.start < begin + 1:
                    here.append(self._now)
                count += 1
                if count > MAX_SEGMENTS:
                    return
            beats.append(Beat(here, _around([_box(each, begin, begin + 1) for each in here])))
        self._blocks.append(Block(beats, _around([beat.box for beat in beats]), BLOCK + count))
        self._is_lost = False


def _body(part: Part) -> tuple[float, float, float]:
    return part.profile.step, part.profile.quarter_turn, part.profile.radius


def _segments(part: Part, start: float) -> Iterator[Segment]:
    """Yield all segments of a robot from a beat on. It stands until it begins, and after it has ended for good."""
    pose = part.entered or part.start
    begins = float(part.begins)
    if begins > start:
        yield _standing(pose, start, begins)
    end = begins
    twists: dict[Velocity, Twist] = {}
    for since, until, velocity in _velocities(part.movement):
        moving = twists.get(velocity)
        if moving is None:
            moving = twists[velocity] = twist(velocity, part.profile, A_BEAT_A_SECOND)
        begin, end = begins + since, begins + until
        segment = _segment(pose, moving, begin, end)
        if end > start:
            yield segment
        if end == math.inf:
            return
        x, y, _, _ = moving_at(segment, end)
        pose = Pose(x, y, pose.z + moving.z * (end - begin), pose.heading + moving.yaw * (end - begin))
    yield _standing(pose, end, math.inf)


def _standing(pose: Pose, since: float, until: float) -> Segment:
    return _segment(pose, Twist(), since, until)


def _segment(pose: Pose, moving: Twist, begin: float, end: float) -> Segment:
    cos, sin = math.cos(pose.heading), math.sin(pose.heading)
    along_x, along_y = cos * moving.x - sin * moving.y, sin * moving.x + cos * moving.y
    turn = moving.yaw if along_x or along_y else 0.0
    return Segment(begin, end, pose.x, pose.y, pose.z, along_x, along_y, moving.z, turn, pose.heading, moving.yaw)


def _velocities(movement: Movement) -> Iterator[tuple[float, float, Velocity]]:
    """Yield the velocities of a movement, from beat to beat. A part that repeats itself for good is walked once."""
    found = cycle(movement) if isinstance(movement.duration, float) else None
    again: list[tuple[float, float, Velocity]] = []
    for moment in walk(movement, merge=True):
        if found and moment.start >= found.begins:
            if not found.beats:
                yield float(moment.start), math.inf, moment.velocity
                return
            if moment.start >= found.begins + found.beats:
                break
            again.append((float(moment.start), float(moment.start + moment.duration), moment.velocity))
        yield float(moment.start), float(moment.start + moment.duration), moment.velocity
    else:
        return
    for turn in count(1):
        later = float(found.beats * turn)
        for begin, end, velocity in again:
            yield begin + later, end + later, velocity


def _box(segment: Segment, begin: float, end: float) -> Volume:
    """Return a box around a segment between two beats.

    No point of a curve is farther from the line between its ends than half the difference between the lengths of both.
    """
    begin, end = max(begin, segment.start), min(end, segment.end)
    x0, y0, _, _ = moving_at(segment, begin)
    x1, y1, _, _ = moving_at(segment, end)
    z0, z1 = (segment.z + segment.along_z * (beat - segment.start) for beat in (begin, end))
    out = 0.0
    if segment.turn:
        speed = math.hypot(segment.along_x, segment.along_y)
        bulge = (speed * (end - begin) - math.hypot(x1 - x0, y1 - y0)) / 2
        out = max(min(bulge, 2 * speed / abs(segment.turn)), 0.0)
    return Volume(min(x0, x1) - out, min(y0, y1) - out, min(z0, z1), max(x0, x1) + out, max(y0, y1) + out, max(z0, z1))


def _around(boxes: Sequence[Volume]) -> Volume:
    if len(boxes) == 1:
        return boxes[0]
    x0, y0, z0, x1, y1, z1 = zip(*boxes, strict=True)
    return Volume(min(x0), min(y0), min(z0), max(x1), max(y1), max(z1))
