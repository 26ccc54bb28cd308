"""Robots' paths from the side, if some of them climb: x to the right, z up. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from improv_core.score.motion import Twist
from improv_core.score.movement import Exact
from improv_core.score.strokes import ENDLESS_BEATS, Path

_TURN = math.pi / 20
"""Radians of a turn for each piece: few enough for a curve that looks smooth."""

Point = tuple[float, float]
"""x and z in meters."""


class SidePiece(NamedTuple):
    """A straight piece of a path. If it isn't `certain`, senses may decide otherwise."""

    start: Point
    end: Point
    certain: bool


@dataclass(frozen=True, slots=True)
class Side:
    """One robot's path. `whole` is false if something had to be left out."""

    start: Point
    end: Point
    pieces: Sequence[SidePiece]
    whole: bool


def sides(drawn: Sequence[Path], most_pieces: int) -> list[Side]:
    """Return each path from the side, repeated pieces only once; none if no robot climbs."""
    if not any(leg.moving.z for path in drawn for leg in path.legs):
        return []
    return [_side(path, most_pieces) for path in drawn]


def _side(path: Path, most_pieces: int) -> Side:
    pieces: dict[tuple[float, ...], SidePiece] = {}
    latest: Exact = 0  # the last time something new was drawn
    whole = path.whole
    for leg in path.legs:
        steps = _steps(leg.moving, leg.seconds)
        at = leg.pose.x, leg.pose.z
        for step in range(1, steps + 1):
            if len(pieces) == most_pieces:
                whole = False
                break
            pose = leg.pose.after(leg.moving, leg.seconds * step / steps)
            piece = SidePiece(at, (pose.x, pose.z), leg.certain)
            at = piece.end
            count = len(pieces)
            pieces.setdefault(tuple(round(value, 6) for point in piece[:2] for value in point), piece)
            latest = leg.start if len(pieces) > count else latest
    repeats = not path.endless or latest < ENDLESS_BEATS / 2
    return Side((path.start.x, path.start.z), (path.end.x, path.end.z), list(pieces.values()), whole and repeats)


def _steps(moving: Twist, seconds: float) -> int:
    return max(math.ceil(abs(moving.yaw * seconds) / _TURN), 1) if moving.x or moving.y else 1
