"""Checks that joints of real robots are where their parts begin, and words the lines about it. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from improv_core.score.body import Joint

FRESH = 1.0
"""Seconds after which a measured position of a joint is too old."""
NEAR_TURN, NEAR_SLIDE = math.radians(2), 0.005
"""The farthest that a joint may be from its start: in radians, or in meters for one that slides."""
FAR_TURN, FAR_SLIDE = math.radians(5), 0.02
"""The farthest that a joint may be from the position at which it was sent to stand: an arm may hang a little."""
MAX_NAMED = 3
"""The most joints that a line names."""


class JointOff(NamedTuple):
    """A joint that isn't at its start, and the distance that is left; None if its position is unknown. `topic` is the
    one that should send the position, if the settings name it. `brought` is true if Improv brings the joint to its
    start."""

    robot: str
    joint: Joint
    left: float | None
    topic: str | None
    brought: bool = False

    @property
    def is_unknown(self) -> bool:
        """True if the position may soon be known."""
        return self.left is None and self.topic is not None


def adrift(joints: Sequence[Joint], measured: Mapping[str, float], told: Sequence[float]) -> bool:
    """Return whether a joint is so far from where it was sent to stand that it would jump if it continued there."""
    return any(is_far(joint, measured[joint.name], place) for joint, place in zip(joints, told, strict=True))


def is_far(joint: Joint, position: float, other: float) -> bool:
    """Return whether two positions of a joint differ by more than it may hang."""
    return abs(position - other) > (FAR_SLIDE if joint.slides else FAR_TURN)


def joints_off(
    robot: str, joints: Sequence[Joint], topic: str | None, measured: Mapping[str, float], brought: bool = False
) -> Iterator[JointOff]:
    """Yield the joints that aren't at their starts, by their latest measured positions."""
    for joint in joints:
        position = measured.get(joint.name)
        if position is None:
            yield JointOff(robot, joint, None, topic)
        elif abs(position - joint.start) > (NEAR_SLIDE if joint.slides else NEAR_TURN):
            yield JointOff(robot, joint, joint.start - position, topic, brought)


def line_of(found: Sequence[JointOff], *, moving: bool = False) -> str:
    """Return one line about what people have to do about joints that aren't at their starts; empty if nothing. `moving`
    is true if other joints move to theirs."""
    nothing = "nothing else moves" if moving else "nothing moves"
    others = [each for each in found if not each.brought]
    if not others:
        return ""
    first = next((each for each in others if each.left is None), others[0])
    if first.topic is None:
        return (
            f"{nothing}: it isn't known where the joints of {first.robot} are: "
            "set `joint_states` in improv.toml to the topic that says it"
        )
    if first.left is None:
        return (
            f"{nothing}: it isn't known where {first.joint.name} of {first.robot} is: start the node that publishes "
            f"its position on {first.topic}, or name it there as in improv.toml"
        )
    return f"{nothing} until all joints are at their starts: turn {_named(others)}"


def line_of_moving(found: Sequence[JointOff]) -> str:
    """Return the line that people see right before joints move to their starts."""
    return f"joints move to their starts first: {_named(found)}"


def _named(found: Sequence[JointOff]) -> str:
    more = [f"and {len(found) - MAX_NAMED} more"] if len(found) > MAX_NAMED else []
    return ", ".join([*map(_way, found[:MAX_NAMED]), *more])


def _way(off: JointOff) -> str:
    assert off.left is not None
    return f"{off.joint.name} of {off.robot} by {in_words(off.joint, off.left)}"


def in_words(joint: Joint, distance: float) -> str:
    """Return `+17°`, or `-0.250 m`."""
    return f"{distance:+.3f} m" if joint.slides else f"{math.degrees(distance):+.0f}°"
