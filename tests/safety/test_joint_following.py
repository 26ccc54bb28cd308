"""Joints that follow the program, or don't, by a clock that the test turns."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from improv_core.safety.joint_following import JointWatch, unfollowed, watched
from improv_core.score.body import Joint

YAW, PITCH = Joint("yaw", max_velocity=math.radians(50)), Joint("pitch")
TICK = 0.05
Motion = Callable[[float], float]


def turns(degrees: float) -> Motion:
    """A joint turns to and fro by this many degrees a second, and back after each second."""
    return lambda at: math.radians(degrees) * (1 - abs(1 - at % 2))


def late(motion: Motion, lag: float) -> Motion:
    return lambda at: motion(max(at - lag, 0.0))


def jammed(motion: Motion, at: float) -> Motion:
    return lambda now: motion(min(now, at))


def watch_of(joint: Joint, program: Motion, real: Motion | None, seconds: float) -> JointWatch:
    watch, speed = JointWatch(), abs(program(TICK) - program(0)) / TICK
    for tick in range(round(seconds / TICK) + 1):
        at, passed = tick * TICK, TICK if tick else 0.0
        watch = watched(watch, joint, passed, program(at), speed, real(at) if real else None, 0.0)
    return watch


def found(*watches: JointWatch, known: bool = True) -> str:
    """Return the likely cause for joints of a head that don't follow; "" if they do."""
    joints = {joint.name: joint for joint in (YAW, PITCH)}
    named = dict(zip(joints, watches, strict=False))
    measured = dict.fromkeys(joints, 0.0) if known else {}
    trouble = unfollowed(named, joints, measured, "head", "/joint_states")
    return trouble.why if trouble else ""


WAY = turns(30)


@pytest.mark.parametrize(
    ("real", "seconds"),
    [
        (WAY, 9.0),
        (late(WAY, 0.3), 9.0),  # a joint may lag
        (lambda at: WAY(at) * 0.7, 9.0),
        (jammed(WAY, 5.5), 6.0),  # for less than a second
        (lambda at: 0.0, 0.9),
    ],
)
def test_a_joint_follows_if_it_covers_half_of_its_way(real: Motion, seconds: float) -> None:
    assert found(watch_of(YAW, WAY, real, seconds)) == ""


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_a_joint_that_does_not_follow_for_a_second_is_found(noise: float) -> None:
    still = lambda at: noise * math.sin(999 * at)  # noqa: E731
    assert found(watch_of(YAW, WAY, still, 1.1)) != ""


def test_a_joint_that_moves_by_less_than_its_start_may_be_off_is_no_fault() -> None:
    assert found(watch_of(YAW, turns(1), lambda at: 0.0, 9.0)) == ""


def test_a_joint_that_follows_again_is_no_fault_anymore() -> None:
    """It jams from 2 s to 4 s."""
    real = lambda at: WAY(2.0) if 2 <= at < 4 else WAY(at)  # noqa: E731
    assert found(watch_of(YAW, WAY, real, 3.5)) != ""
    assert found(watch_of(YAW, WAY, real, 5.0)) == ""


def test_the_likely_cause_is_named() -> None:
    still = watch_of(YAW, WAY, lambda at: 0.0, 2.0)
    moves, unknown = watch_of(PITCH, WAY, WAY, 2.0), watch_of(YAW, WAY, None, 2.0)
    assert found(still) == "head moves nothing: its log says if it is inactive or refuses what it gets"
    assert found(still, still) == found(still)
    assert found(still, moves) == "head no longer moves yaw: look for what holds it back"
    assert found(watch_of(YAW, WAY, jammed(WAY, 5.5), 8.0)) == found(still, moves)
    assert found(unknown, known=False) == "no position of yaw comes on /joint_states: check the node that publishes it"
    fast = watch_of(YAW, turns(200), lambda at: turns(50)(at), 2.0)
    assert found(fast) == "the program asks yaw for far more than its `max_velocity`: `improv check` shows the place"
