"""Checks that real robots stand where the program has them, before they begin. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

from improv_core.protocol.fields import to_pose_json
from improv_core.protocol.messages import Misplaced
from improv_core.score.motion import Pose
from improv_core.score.score import Preflight

NAMED = 3
"""The most robots that a line names; the page shows all."""
SWAPPED = 0.3
"""Two robots seem to be swapped if the distance of each from the other's place is at most this share of the distance
from its own."""
COMPARED = 50
"""The most robots of which two may be found to be swapped: every two are compared."""
NEAR = 0.03
"""If a robot has to be turned, a distance of less than this many meters is left out of the advice; and vice versa in
radians (two degrees)."""


class Standing(NamedTuple):
    """A robot's ideal pose, and its measured one in the same frame; None if unknown, perhaps because of `why`."""

    ideal: Pose
    pose: Pose | None
    why: str = ""


def misplaced(places: Mapping[str, Standing], limits: Preflight) -> dict[str, Standing]:
    """Return the robots that are farther from their places than the limits allow, or whose poses are unknown."""
    return {robot: place for robot, place in places.items() if not is_there(place, limits)}


def message(found: Mapping[str, Standing] | None, generation: int) -> Misplaced:
    """Return the message to pages about these robots; None if nothing waits for robots anymore."""
    lines = _advice_for(found or {})
    return {
        "type": "misplaced",
        "generation": generation,
        "waits": found is not None,
        "robots": {
            robot: {
                "place": to_pose_json(each.ideal),
                "pose": to_pose_json(each.pose) if each.pose else None,
                "line": lines[robot],
            }
            for robot, each in (found or {}).items()
        },
    }


def advice(robot: str, place: Standing) -> str:
    """Return the advice that puts a robot in its place, such as `move ada 0.36 m toward 120° and turn it 5° left`.
    Directions are degrees, counterclockwise from the x axis."""
    ideal, pose, why = place
    if not pose:
        return f"nobody knows where {robot} stands: {why or 'its poses have to arrive'}"
    x, y = ideal.x - pose.x, ideal.y - pose.y
    far, turn = math.hypot(x, y), _turn(place)
    toward = round(math.degrees(math.atan2(y, x))) % 360
    turned = f"{abs(math.degrees(turn)):.0f}° {'left' if turn > 0 else 'right'}"
    if far < NEAR <= abs(turn):
        return f"turn {robot} {turned}"
    moved = f"move {robot} {far:.2f} m toward {toward}°"
    return moved if abs(turn) < NEAR <= far else f"{moved} and turn it {turned}"


def refusal(found: Mapping[str, Standing]) -> str:
    """Return the line about robots that are not in their places."""
    lines = shown(found)
    more = f", and {len(lines) - NAMED:,} more" if len(lines) > NAMED else ""
    return (
        f"✗ doesn't begin: {', '.join(lines[:NAMED])}{more}; then play again (`--force` or *Begin anyway* ignores this)"
    )


def shown(found: Mapping[str, Standing]) -> Sequence[str]:
    """Return the lines that people see; while they stay the same, nothing has to be shown again."""
    return [*dict.fromkeys(_advice_for(found).values())]


def is_there(place: Standing, limits: Preflight) -> bool:
    ideal, pose, _ = place
    if not pose:
        return False
    return math.hypot(ideal.x - pose.x, ideal.y - pose.y) <= limits.distance and abs(_turn(place)) <= limits.turn


def _advice_for(found: Mapping[str, Standing]) -> dict[str, str]:
    """Return the advice for each of several robots. Two that stand in each other's places have one in common."""
    lines = {robot: advice(robot, place) for robot, place in found.items()}
    for one, other in combinations([*found][:COMPARED], 2):
        if _is_nearer(found[one], found[other]) and _is_nearer(found[other], found[one]):
            lines[one] = lines[other] = f"swap {one} and {other}"
    return lines


def _is_nearer(one: Standing, other: Standing) -> bool:
    """Return whether a robot stands much nearer to the place of another one than to its own."""
    if not one.pose or not other.pose:
        return False
    return other.ideal.apart(one.pose)[0] < SWAPPED * one.ideal.apart(one.pose)[0]


def _turn(place: Standing) -> float:
    """Return the angle by which it has to be turned to the left, in radians."""
    return math.remainder(place.ideal.heading - place.pose.heading, math.tau) if place.pose else 0.0
