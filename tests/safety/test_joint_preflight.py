"""The lines about joints that aren't at their starts."""

from __future__ import annotations

import math

import pytest

from improv_core.safety.joint_preflight import joints_off, line_of, line_of_moving
from improv_core.score.body import Joint

YAW, LIFT = Joint("yaw", start=math.radians(10)), Joint("lift", slides=True)
OTHERS = [Joint("a"), Joint("b"), Joint("c")]
TOPIC = "/ada/joint_states"
NOTHING_UNTIL = "nothing moves until all joints are at their starts: turn"


def line(*joints: Joint, topic: str | None = TOPIC, **measured: float) -> str:
    return line_of([*joints_off("ada", joints, topic, measured)])


@pytest.mark.parametrize(
    ("degrees", "meters", "said"),
    [
        (10, 0, ""),
        (11.9, 0.0049, ""),
        (8.1, -0.0049, ""),
        (12.1, 0, f"{NOTHING_UNTIL} yaw of ada by -2°"),
        (-35, 0, f"{NOTHING_UNTIL} yaw of ada by +45°"),
        (10, 0.01, f"{NOTHING_UNTIL} lift of ada by -0.010 m"),
        (0, -1, f"{NOTHING_UNTIL} yaw of ada by +10°, lift of ada by +1.000 m"),
    ],
)
def test_joints_and_how_far_they_have_to_go(degrees: float, meters: float, said: str) -> None:
    assert line(YAW, LIFT, yaw=math.radians(degrees), lift=meters) == said


def test_only_a_few_are_named() -> None:
    assert line(YAW, *OTHERS, yaw=0, a=1, b=1, c=1).endswith("a of ada by -57°, b of ada by -57°, and 1 more")


def test_the_positions_of_joints_must_be_known() -> None:
    assert line(YAW, LIFT, lift=3.0) == (
        "nothing moves: it isn't known where yaw of ada is: start the node that publishes its position on "
        "/ada/joint_states, or name it there as in improv.toml"
    )
    assert line(YAW, topic=None) == (
        "nothing moves: it isn't known where the joints of ada are: set `joint_states` in improv.toml to the topic "
        "that says it"
    )


def test_joints_that_are_brought_to_their_starts() -> None:
    off = [*joints_off("ada", [YAW], TOPIC, {"yaw": 0}, True)]
    assert line_of(off) == "", "nobody has to do anything"
    assert line_of_moving(off) == "joints move to their starts first: yaw of ada by +10°"


def test_no_line_claims_that_nothing_moves_while_other_joints_do() -> None:
    off = [*joints_off("ada", [YAW], TOPIC, {"yaw": 0}, True), *joints_off("bo", [YAW], TOPIC, {"yaw": 0})]
    assert line_of(off) == f"{NOTHING_UNTIL} yaw of bo by +10°"
    assert line_of(off, moving=True).startswith("nothing else moves until all joints are at their starts: turn yaw of")
    unknown = [*joints_off("ada", [YAW, LIFT], TOPIC, {"yaw": 0})]
    assert line_of(unknown, moving=True).startswith("nothing else moves: it isn't known where lift of ada is: ")
