"""The simulator: exact paths, the same poses under any load, and robots that don't pass through each other."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.path import pose_at
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, Score
from improv_core.stage.dry_run import perform as rehearse

FORWARD, LEFT = Twist(x=2.0), Twist(yaw=math.pi / 2)
RADIUS = 0.3


def part(robot: str, start: Pose | None = None, radius: float = RADIUS) -> Part:
    return Part(robot, (), Profile("disc", step=2.0, radius=radius), start or Pose(), f"/{robot}/cmd_vel")


def stage(*parts: Part) -> Simulator:
    simulator = Simulator()
    simulator.prepare(Score(Fraction(60), {each.robot: each for each in parts}), restart=True)
    return simulator


def perform(simulator: Simulator, robot: str, twists: Iterable[tuple[float, Twist]], end: float) -> Pose:
    """Send everything, with a stop at the end, and advance to the end in frames of 1/60 s."""
    for at, twist in twists:
        simulator.send(robot, twist, at)
    simulator.send(robot, STILL, end)
    for frame in range(int(end * 60) + 1):
        simulator.advance(frame / 60)
    simulator.advance(end)
    return simulator.poses()[robot]


def near(pose: Pose, expected: Pose, within: float = 1e-9) -> bool:
    return (
        math.dist((pose.x, pose.y, pose.z), (expected.x, expected.y, expected.z)) < within
        and abs(pose.heading - expected.heading) < within
    )


def gap(simulator: Simulator, one: str, other: str) -> float:
    """The free space between two robots, negative while they overlap."""
    poses = simulator.poses()
    return math.hypot(poses[one].x - poses[other].x, poses[one].y - poses[other].y) - 2 * RADIUS


def test_the_ground_holds_a_robot_that_goes_down() -> None:
    twists = [(0.0, Twist(z=1)), (1.0, Twist(x=1, z=-1)), (3.0, Twist(z=1))]
    for end, expected in ((1.75, Pose(0.75, 0, 0.25)), (2.5, Pose(1.5)), (4.0, Pose(2, 0, 1))):
        simulator = stage(part("a"))
        assert near(perform(simulator, "a", [each for each in twists if each[0] <= end], end), expected)


@pytest.mark.parametrize(
    "program", ["beat 97\nr $ repeat (forward left)", "beat 97\nr $ repeat (forward || left || strafeleft)"]
)
def test_a_robot_is_on_its_path_after_five_minutes(program: str) -> None:
    score, simulator = score_of(analyze(program)), Simulator(period=None)
    rehearse(score, simulator, seconds=300)
    expected = pose_at(score.parts["r"], Fraction(97 * 5))
    assert expected
    assert near(simulator.poses()["r"], expected, within=1e-8)


@pytest.mark.parametrize("aside", [0.0, 0.05])
def test_robots_head_on_neither_overlap_nor_pass(aside: float) -> None:
    simulator = stage(part("a"), part("b", Pose(3.0, aside, 0.0, math.pi)))
    simulator.send("a", FORWARD, 0.0)
    simulator.send("b", FORWARD, 0.0)
    for frame in range(90):
        simulator.advance(frame * 0.0123)
        # The first touch may be as deep as both move in one step.
        assert gap(simulator, "a", "b") > -2 * 2.0 / 240
        if aside == 0.0:
            assert simulator.poses()["a"].x < simulator.poses()["b"].x
    if aside == 0.0:
        assert gap(simulator, "a", "b") == pytest.approx(0.0, abs=0.003)


def test_a_pushed_robot_continues_from_where_it_is() -> None:
    simulator = stage(part("mover"), part("still", Pose(1.0)))
    simulator.send("mover", FORWARD, 0.0)
    simulator.send("mover", STILL, 1.0)
    simulator.advance(2.0)
    resting = simulator.poses()
    assert resting["still"].x > 1.3
    assert resting["still"].heading == 0.0
    assert resting["mover"].x < 2.0
    simulator.send("still", LEFT, 2.0)
    simulator.send("still", FORWARD, 3.0)
    simulator.advance(4.0)
    assert simulator.poses()["still"].x == pytest.approx(resting["still"].x, abs=1e-3)
    assert simulator.poses()["still"].y == pytest.approx(2.0, abs=1e-3)


def test_robots_that_start_in_one_place_are_pushed_apart() -> None:
    simulator = stage(part("a"), part("b"))
    simulator.advance(3.0)
    assert gap(simulator, "a", "b") > -0.01


def test_a_restart_puts_all_robots_at_their_starts_at_time_zero() -> None:
    simulator = stage(part("a"), part("gone", Pose(5.0)))
    simulator.send("a", FORWARD, 0.0)
    simulator.advance(1.3)
    simulator.prepare(Score(Fraction(60), {"a": part("a", Pose(1.0, 2.0))}), restart=True)
    assert simulator.poses() == {"a": Pose(1.0, 2.0)}
    assert simulator.snapshot().at == 0.0
    simulator.send("a", FORWARD, 0.0)
    simulator.advance(0.5)
    assert near(simulator.poses()["a"], Pose(2.0, 2.0))


def test_without_restart_robots_continue_and_those_left_out_stay() -> None:
    simulator = stage(part("a"), part("gone", Pose(0.0, 3.0)))
    simulator.send("a", FORWARD, 0.0)
    simulator.send("gone", FORWARD, 0.0)
    simulator.advance(1.001)
    simulator.prepare(Score(Fraction(60), {"a": part("a"), "new": part("new", Pose(0.0, -3.0))}), restart=False)
    assert list(simulator.poses()) == ["a", "gone", "new"]
    simulator.send("a", LEFT, 1.001)
    simulator.send("gone", STILL, 1.001)
    simulator.send("new", FORWARD, 1.001)
    simulator.advance(2.001)
    poses = simulator.poses()
    assert near(poses["a"], Pose(2.002, 0.0, 0.0, math.pi / 2))
    assert near(poses["gone"], Pose(2.002, 3.0))
    assert near(poses["new"], Pose(2.0, -3.0))
