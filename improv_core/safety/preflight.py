"""Whether real robots stand where the program has them, before they begin. Pure functions; standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from improv_core.protocol.fields import to_pose_json
from improv_core.protocol.messages import Misplaced
from improv_core.score.motion import Pose
from improv_core.score.score import Preflight

NAMED = 3
"""So many robots are named in a line; the page shows all."""
NEAR = 0.03
"""Meters that nobody is asked to move a robot that has to be turned, and vice versa in radians (two degrees)."""


class Standing(NamedTuple):
    """Where a robot should be, and where it stands in the same frame; None if that is not known."""

    ideal: Pose
    pose: Pose | None


def misplaced(places: Mapping[str, Standing], limits: Preflight) -> dict[str, Standing]:
    """The robots that are farther from their places than they may be, or of which that is not known."""
    return {robot: place for robot, place in places.items() if not is_there(place, limits)}


def message(found: Mapping[str, Standing] | None, generation: int) -> Misplaced:
    """What the page shows; None if nothing waits for robots anymore."""
    return {
        "type": "misplaced",
        "generation": generation,
        "waits": found is not None,
        "robots": {
            robot: {
                "place": to_pose_json(each.ideal),
                "pose": to_pose_json(each.pose) if each.pose else None,
                "line": advice(robot, each),
            }
            for robot, each in (found or {}).items()
        },
    }


def advice(robot: str, place: Standing) -> str:
    """What somebody has to do so that a robot is in its place, such as `move ada 0.36 m toward 120° and turn it 5°
    left`. Directions are degrees, counterclockwise from the x axis."""
    ideal, pose = place
    if not pose:
        return f"nobody knows where {robot} stands: its poses have to arrive"
    x, y = ideal.x - pose.x, ideal.y - pose.y
    far, turn = math.hypot(x, y), _turn(place)
    toward = round(math.degrees(math.atan2(y, x))) % 360
    turned = f"{abs(math.degrees(turn)):.0f}° {'left' if turn > 0 else 'right'}"
    if far < NEAR <= abs(turn):
        return f"turn {robot} {turned}"
    moved = f"move {robot} {far:.2f} m toward {toward}°"
    return moved if abs(turn) < NEAR <= far else f"{moved} and turn it {turned}"


def refusal(found: Mapping[str, Standing]) -> str:
    """The line about robots that are not in their places."""
    lines = [advice(robot, place) for robot, place in found.items()]
    more = f", and {len(lines) - NAMED:,} more" if len(lines) > NAMED else ""
    return (
        f"✗ doesn't begin: {', '.join(lines[:NAMED])}{more}; then play again (`--force` or *Begin anyway* ignores this)"
    )


def shown(found: Mapping[str, Standing]) -> Sequence[str]:
    """What people see of it: it only changes if one of these lines does."""
    return [advice(robot, place) for robot, place in found.items()]


def is_there(place: Standing, limits: Preflight) -> bool:
    """Whether a robot is near enough to its place."""
    ideal, pose = place
    if not pose:
        return False
    return math.hypot(ideal.x - pose.x, ideal.y - pose.y) <= limits.distance and abs(_turn(place)) <= limits.turn


def _turn(place: Standing) -> float:
    """How far it has to be turned to the left, in radians."""
    return math.remainder(place.ideal.heading - place.pose.heading, math.tau) if place.pose else 0.0
