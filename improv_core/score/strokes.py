"""The ideal paths of a score as lines and arcs, to be drawn. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement
from improv_core.score.prediction import Prediction
from improv_core.score.score import Part, Score, twist
from improv_core.score.suppositions import as_pictured, certain_beats
from improv_core.score.walk import walk

MAX_STROKES = 400
"""The most lines and arcs of a path. This keeps a picture under 20 KB, which suits hovers in editors."""
MAX_MOMENTS = 20_000
"""The most moments of a path that are walked."""
ENDLESS_BEATS = 64
"""The number of beats drawn of an endless movement."""
_FLAT = 1e-9
"""Meters or radians: anything smaller is not drawn."""
_LONGEST = math.pi * 0.9
"""The most radians of an arc: less than half a circle."""
_SHORT = math.pi / 20
"""The same if robots climb: so few that a curve looks smooth although it is drawn as lines from the side."""


class Stroke(NamedTuple):
    """A stretch of a path from one pose to another, along a circle with this radius in meters (0: a straight line).

    `turn` is in radians, counterclockwise: that of the whole moment, of which this may be a piece.
    """

    start: Pose
    end: Pose
    radius: float
    turn: float


@dataclass(frozen=True, slots=True)
class Path:
    """One robot's path. `whole` is false if something had to be left out.

    Strokes from `certain` on are as they are pictured, but senses may decide otherwise.
    """

    robot: str
    start: Pose
    end: Pose
    strokes: Sequence[Stroke]
    whole: bool
    certain: int
    endless: bool


def paths(
    score: Score,
    most_moments: int = MAX_MOMENTS,
    prediction: Prediction | None = None,
    most_strokes: int = MAX_STROKES,
) -> list[Path]:
    """Return the ideal path of each robot: only the first beats of an endless path, and repeated strokes only once.
    Where a prediction assumes nothing, a path is certain."""
    drawn = prediction.score if prediction else pictured(score)
    longest = _SHORT if any(part.movement.bounds.peak.z for part in drawn.parts.values()) else _LONGEST
    found = []
    for name, part in drawn.parts.items():
        is_certain = prediction and name not in prediction.assuming
        assumed = (part if is_certain else score.parts[name]).movement
        path = path_of(drawn, part, assumed, most_moments, most_strokes, longest=longest)
        found.append(replace(path, whole=False) if prediction and prediction.cut is not None else path)
    return found


def outermost(path: Path) -> Iterator[tuple[float, float]]:
    """Yield the outermost points of a path, among others."""
    yield path.start.x, path.start.y
    for stroke in path.strokes:
        yield stroke.end.x, stroke.end.y
        if stroke.radius:
            yield from _extremes(stroke)


def _extremes(stroke: Stroke) -> Iterator[tuple[float, float]]:
    """Yield the points of an arc that are farthest along x or y, except its ends."""
    x, y = stroke.end.x - stroke.start.x, stroke.end.y - stroke.start.y
    sweep = math.copysign(2 * math.asin(min(math.hypot(x, y) / 2 / stroke.radius, 1.0)), stroke.turn)
    begin = math.atan2(y, x) - sweep / 2 - math.copysign(math.pi / 2, sweep)  # the angle of its start at its center
    first, last = sorted((begin, begin + sweep))
    for quarter in range(math.ceil(first * 2 / math.pi), math.floor(last * 2 / math.pi) + 1):
        angle = quarter * math.pi / 2
        across, up = math.cos(angle) - math.cos(begin), math.sin(angle) - math.sin(begin)
        yield stroke.start.x + stroke.radius * across, stroke.start.y + stroke.radius * up


def apex(stroke: Stroke) -> tuple[float, float]:
    """Return the point of an arc that is farthest from the line between its ends."""
    (x0, y0), (x1, y1) = (stroke.start.x, stroke.start.y), (stroke.end.x, stroke.end.y)
    half = math.dist((x0, y0), (x1, y1)) / 2
    # The difference of squares could be too large for a float, so take two square roots.
    bulge = stroke.radius - math.sqrt(max(stroke.radius - half, 0.0)) * math.sqrt(stroke.radius + half)
    across = math.copysign(bulge, stroke.turn) / max(2 * half, _FLAT)
    return (x0 + x1) / 2 + (y1 - y0) * across, (y0 + y1) / 2 - (x1 - x0) * across


def pictured(score: Score) -> Score:
    """Return the score as it is pictured, with an assumption for each decision of a sense."""
    if not any(scene.open for part in score.parts.values() for scene in part.scenes):
        return score
    parts = {
        name: replace(part, scenes=tuple(map(as_pictured, part.scenes)), scene_begins=())
        for name, part in score.parts.items()
    }
    return replace(score, parts=parts)


def path_of(
    score: Score,
    part: Part,
    assumed: Movement,
    most_moments: int = MAX_MOMENTS,
    most_strokes: int = MAX_STROKES,
    most_beats: Duration | None = None,
    longest: float = _LONGEST,
) -> Path:
    """Return the ideal path of a part for what a program `assumed`, as `paths` does: up to `most_beats`, by default the
    first beats of an endless path and all of another. No arc turns by more than `longest` radians."""
    moving_at = cache(lambda velocity: twist(velocity, part.profile, score.tempo))  # most moments have few velocities
    seconds_of = cache(score.seconds)
    endless = part.movement.duration == ENDLESS
    until = most_beats if most_beats is not None else ENDLESS_BEATS if endless else ENDLESS
    pose = part.start
    strokes: dict[tuple[float, ...], Stroke] = {}
    latest: Exact = 0  # the last time something new was drawn
    whole = True
    doubtful = certain_beats(assumed, part.movement, most_moments)
    certain: int | None = None
    for walked, moment in enumerate(walk(part.movement, merge=True, evenly=True)):
        if moment.start >= doubtful and certain is None:
            certain = len(strokes)
        if moment.start >= until:
            whole = endless and latest < until / 2  # it only repeats itself
            break
        if not whole or walked == most_moments:
            whole = False
            break
        seconds = seconds_of(min(moment.duration, until))
        for stroke in _strokes(pose, moving_at(moment.velocity), seconds, longest):
            if len(strokes) == most_strokes:
                whole = False
                break
            pose = stroke.end
            ends = (*_place(stroke.start), *_place(pose))
            if math.dist(ends[:3], ends[3:]) > _FLAT:
                count = len(strokes)
                strokes.setdefault(tuple(round(value, 6) for value in (*ends, stroke.turn)), stroke)
                latest = moment.start if len(strokes) > count else latest
    sure = len(strokes) if certain is None else certain
    return Path(part.robot, part.start, pose, list(strokes.values()), whole, sure, endless)


def _place(pose: Pose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.z


def _strokes(pose: Pose, moving: Twist, seconds: float, longest: float) -> Iterator[Stroke]:
    """Yield a moment as a line, or as arcs: at most one full circle, unless the robot climbs."""
    speed = math.hypot(moving.x, moving.y)
    turn = moving.yaw * seconds
    if abs(turn) < _FLAT or not speed:
        yield Stroke(pose, pose.after(moving, seconds), 0.0, 0.0)
        return
    radius = speed / abs(moving.yaw)
    drawn = turn if moving.z else math.copysign(min(abs(turn), math.tau), turn)
    pieces = math.ceil(abs(drawn) / longest)
    for piece in range(pieces):
        start = pose.after(moving, seconds * drawn / turn * piece / pieces)
        end = pose.after(moving, seconds * drawn / turn * (piece + 1) / pieces)
        yield Stroke(start, end, radius, turn)
    if drawn != turn:
        end = pose.after(moving, seconds)
        yield Stroke(end, end, 0.0, 0.0)
