"""Walls, obstacles, heights, and bumps: simulated robots can't pass them, and the simulator reports bumps."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.meetings import check_room
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, Score
from improv_core.score.world import Box, Circle, Wall, World
from improv_core.stage.dry_run import perform as rehearse

RADIUS = 0.3
FORWARD = Twist(x=2.0)


def stage(world: World, dynamics: str = "ideal", **starts: Pose) -> Simulator:
    profile = Profile("disc", step=2.0, radius=RADIUS, dynamics=dynamics)
    simulator = Simulator()
    parts = {name: Part(name, (), profile, start, f"/{name}/cmd_vel") for name, start in starts.items()}
    simulator.prepare(Score(Fraction(60), parts, world=world), restart=True)
    return simulator


def drive(simulator: Simulator, seconds: float, **twists: Twist) -> dict[str, Pose]:
    for robot, twist in twists.items():
        simulator.send(robot, twist, 0.0)
    for frame in range(int(seconds * 60) + 1):
        simulator.advance(frame / 60)
    return simulator.poses()


@pytest.mark.parametrize(
    ("world", "stops_at", "thing"),
    [
        (World(size=(6, 6)), 3 - RADIUS, "the edge of the floor"),
        (World(walls=(Wall(2, -1, 2, 1),)), 2 - RADIUS, "a wall"),
        (World(circles=(Circle(2, 0, 0.5),)), 1.5 - RADIUS, "an obstacle"),
        (World(boxes=(Box(2, 0, 1, 2),)), 1.5 - RADIUS, "an obstacle"),
        (World(boxes=(Box(2, 0, 2, 1, math.pi / 2),)), 1.5 - RADIUS, "an obstacle"),
        (World(walls=(Wall(-2, -1, -2, 1),)), None, ""),
    ],
)
def test_robots_pass_no_wall_or_obstacle(world: World, stops_at: float | None, thing: str) -> None:
    simulator = stage(world, a=Pose())
    pose = drive(simulator, 3.0, a=FORWARD)["a"]
    assert pose.x == pytest.approx(6.0 if stops_at is None else stops_at, abs=0.002)
    assert pose.y == pytest.approx(0.0, abs=1e-6)
    assert pose.heading == 0.0
    found = [(bump.robots, bump.thing) for bump in simulator.snapshot().bumps]
    assert found == ([] if stops_at is None else [(("a",), thing)])


def test_a_bump_has_its_time_and_place() -> None:
    simulator = stage(World(walls=(Wall(2, -1, 2, 1),)), a=Pose())
    drive(simulator, 2.0, a=FORWARD)
    (bump,) = simulator.snapshot().bumps
    assert bump.at == pytest.approx((2 - RADIUS) / 2, abs=2 / 240)
    assert (bump.x, bump.y) == pytest.approx((2.0, 0.0), abs=0.01)
    assert simulator.warnings() == {"a": "a bumped into a wall: change its start or its path"}
    assert simulator.warnings({"b"}) == {}
    simulator.label = {"a": "Ada: a", "a wall": "a wall"}.__getitem__
    assert simulator.warnings() == {"a": "Ada: a bumped into a wall: change its start or its path"}


def test_robots_that_meet_twice_bump_twice_but_are_warned_about_once() -> None:
    simulator = stage(World(), a=Pose(), b=Pose(2.0, heading=math.pi))
    for at, twist in [(0.0, FORWARD), (1.0, Twist(x=-2.0)), (2.0, FORWARD)]:
        for robot in ("a", "b"):
            simulator.send(robot, twist, at)
    simulator.advance(4.0)
    assert [bump.robots for bump in simulator.snapshot().bumps] == [("a", "b"), ("a", "b")]
    assert simulator.warnings() == {"a": "a bumped into b: start them farther apart or change their paths"}


@pytest.mark.parametrize(("height", "passes"), [(0.0, False), (0.5, False), (0.7, True)])
def test_a_robot_flying_above_another_passes(height: float, passes: bool) -> None:
    simulator = stage(World(), a=Pose(), above=Pose(2.0, z=height))
    pose = drive(simulator, 2.0, a=FORWARD)["a"]
    assert (pose.x == pytest.approx(4.0)) is passes
    assert (simulator.snapshot().bumps == ()) is passes
    assert (simulator.poses()["above"] == Pose(2.0, z=height)) is passes


def test_a_robot_that_lands_on_another_bumps_once() -> None:
    simulator = stage(World(), a=Pose(z=1.0), b=Pose(0.1))
    for at, twist in [(0.0, STILL), (0.5, Twist(z=-0.5)), (2.5, STILL)]:
        simulator.send("a", twist, at)
    simulator.advance(1.2)
    assert simulator.snapshot().bumps == ()
    assert simulator.poses()["b"] == Pose(0.1)
    poses = drive(simulator, 3.0)
    assert poses["b"].x - poses["a"].x == pytest.approx(2 * RADIUS, abs=0.01)
    (bump,) = simulator.snapshot().bumps
    assert bump.robots == ("a", "b")
    assert bump.at == pytest.approx(0.5 + (1.0 - 2 * RADIUS) / 0.5, abs=2 / 240)


@pytest.mark.parametrize("waits", [0.0, 1.0])
def test_a_robot_that_starts_in_a_wall_bumps_once_when_it_drives_on(waits: float) -> None:
    simulator = stage(World(size=(6, 6)), a=Pose(2.9, 2.9))
    simulator.send("a", FORWARD, waits)
    simulator.advance(waits + 3.0)
    (bump,) = simulator.snapshot().bumps
    assert bump.at == pytest.approx(waits, abs=2 / 240)


@pytest.mark.parametrize(("radius", "speed"), [(0.3, 160.0), (0.3, 1000.0), (0.01, 3.0), (0.01, 30.0), (0.001, 2.0)])
def test_small_and_fast_robots_pass_nothing_either(radius: float, speed: float) -> None:
    profile = Profile("disc", step=2.0, radius=radius)
    for world in (World(size=(6, 6)), World(boxes=(Box(4, 0, 2, 2),)), World(walls=(Wall(3, 1, 3, -1),))):
        simulator = Simulator()
        score = Score(Fraction(60), {"a": Part("a", (), profile, Pose(), "/a/cmd_vel")}, world=world)
        simulator.prepare(score, restart=True)
        simulator.send("a", Twist(x=speed), 0.0)
        there = 3 / speed + 0.5
        simulator.advance(there)
        simulator.send("a", STILL, there)  # and the wall doesn't throw it back
        simulator.advance(there + 0.1)
        assert simulator.poses()["a"].x == pytest.approx(3 - radius, abs=0.002)
        assert [bump.robots for bump in simulator.snapshot().bumps] == [("a",)]


def test_another_world_counts_at_once_and_a_restart_forgets_bumps() -> None:
    simulator = stage(World(), a=Pose())
    drive(simulator, 0.5, a=FORWARD)
    parts = {"a": Part("a", (), Profile("disc", 2.0, radius=RADIUS), Pose(), "/a/cmd_vel")}
    simulator.prepare(Score(Fraction(60), parts, world=World(walls=(Wall(2, -1, 2, 1),))), restart=False)
    simulator.advance(3.0)
    assert simulator.poses()["a"].x == pytest.approx(2 - RADIUS, abs=0.002)
    assert simulator.warnings()
    simulator.prepare(Score(Fraction(60), parts), restart=True)
    assert (simulator.snapshot().bumps, simulator.warnings()) == ((), {})
    assert drive(simulator, 2.0, a=FORWARD)["a"].x == pytest.approx(4.0)


def test_motors_push_no_harder_than_they_are_strong_and_turn_while_they_scrape_along_a_wall() -> None:
    """The ideal one always gains ground; the other can't push away a base as strong as itself."""
    pushed, turned = {}, {}
    for dynamics in ("ideal", "motors"):
        pushed[dynamics] = drive(stage(World(), dynamics, a=Pose(), b=Pose(2 * RADIUS)), 3.0, a=FORWARD)["b"].x
        scrapes = stage(World(walls=(Wall(-9, 1, 9, 1),)), dynamics, a=Pose(heading=math.pi / 4))
        turned[dynamics] = drive(scrapes, 3.0, a=FORWARD)["a"].heading - math.pi / 4
    assert pushed["ideal"] == pytest.approx(3.0 + 2 * RADIUS, abs=0.05)
    assert 0 < pushed["motors"] - 2 * RADIUS < 0.1
    assert (turned["ideal"], abs(turned["motors"]) > 0.01) == (0, True)


twists = st.builds(
    Twist,
    x=st.floats(-2, 2) | st.sampled_from([-200.0, 60.0]),
    y=st.sampled_from([0.0, 0.5]),
    yaw=st.floats(-3, 3),
)


@pytest.mark.slow("simulates many collisions")
@settings(max_examples=5)
@given(
    st.lists(st.tuples(st.floats(0, 1), st.sampled_from("abc"), twists), max_size=12),
    st.lists(st.floats(0, 1.5), max_size=20),
    st.sampled_from(["ideal", "motors"]),
)
def test_poses_are_identical_at_any_frame_rate(
    told: list[tuple[float, str, Twist]], frames: list[float], dynamics: str
) -> None:
    world = World(size=(4, 3), circles=(Circle(0.5, 0.9, 0.2),), boxes=(Box(-1, -1, 0.5, 0.3, 0.3),))
    starts = {"a": Pose(-1), "b": Pose(1, heading=math.pi), "c": Pose(0, -0.8, heading=1)}
    ends = []
    for times in ([], frames, [frame / 60 for frame in range(90)]):
        simulator = stage(world, dynamics, **starts)
        # As the player does: it first sends everything that is due, then it advances time.
        events = sorted(
            [(at, 0, robot, twist) for at, robot, twist in told] + [(at, 1, "", STILL) for at in times],
            key=lambda event: event[:2],
        )
        for at, frame, robot, twist in events:
            if frame:
                simulator.advance(at)
            else:
                simulator.send(robot, twist, at)
        simulator.advance(1.5)
        ends.append((simulator.poses(), simulator.snapshot().bumps))
    assert ends[0] == ends[1] == ends[2]


@pytest.mark.parametrize(("apart", "meets"), [(0.59977, False), (0.5992, False), (0.5988, True)])
def test_robots_bump_if_the_check_finds_that_they_meet(apart: float, meets: bool) -> None:
    """Ada drives half a circle, and is nearest to bo in the middle of it."""
    far = 4 / math.pi
    places = f"ada at 0 0\nbo at {far + apart:.9f} {far:.9f}\n"
    score = score_of(analyze(f"{places}ada $ repeat 2 (forward || left)\nbo $ rest\n"))
    simulator = Simulator()
    rehearse(score, simulator)
    assert bool(check_room(score).meetings) == bool(simulator.snapshot().bumps) == meets


@pytest.mark.parametrize(("apart", "meets"), [(0.2998, False), (0.2992, False), (0.2988, True)])
def test_a_robot_bumps_into_a_wall_if_the_check_finds_that_it_hits_it(apart: float, meets: bool) -> None:
    at = 4 / math.pi + apart
    robots = read_robots(f"[world]\nwalls = [[{at}, -9, {at}, 9]]")
    score = score_of(analyze("ada at 0 0\nada $ repeat 2 (forward || left)\n", robots))
    simulator = Simulator()
    rehearse(score, simulator)
    assert bool(check_room(score).hits) == bool(simulator.snapshot().bumps) == meets
