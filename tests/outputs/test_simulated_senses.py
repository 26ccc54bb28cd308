"""Senses of simulated robots, and the times of their edges: `sensed` is called like a player does, in frames of any
length."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.drawn import Bump
from improv_core.protocol.output import Edge
from improv_core.score.dynamics import STEPS_PER_SECOND
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, Score
from improv_core.score.senses import BUILT_IN, RobotSense, Source, Topic
from improv_core.score.world import Box, Circle, Wall, World

RADIUS, NEAR = 0.3, 1.0
DISC = Profile("disc", step=NEAR, radius=RADIUS)
FORWARD, BACKWARD, TURN = Twist(x=1.0), Twist(x=-1.0), Twist(yaw=math.pi)
WALL = World(walls=(Wall(3, -1, 3, 1),))
AT_WALL = 3 - RADIUS
STEP = 1 / STEPS_PER_SECOND


def stage(world: World, senses: Mapping[str, Source] = BUILT_IN, profile: Profile = DISC, **starts: Pose) -> Simulator:
    simulator = Simulator()
    parts = {name: Part(name, (), profile, start, f"/{name}/cmd_vel", senses=senses) for name, start in starts.items()}
    simulator.prepare(Score(Fraction(60), parts, world=world), restart=True)
    return simulator


Orders = Sequence[tuple[float, str, Twist]]


def perform(
    simulator: Simulator, orders: Orders, asked: Sequence[str], until: float, frame: float = 1 / 60
) -> list[Edge]:
    """Return all edges of these senses, such as "a near", while robots get these twists at these times."""
    senses = {RobotSense(*each.split()) for each in asked}
    found: list[Edge] = []
    times = sorted({min(step * frame, until) for step in range(int(until / frame) + 2)} | {at for at, *_ in orders})
    for time in times:
        while edges := simulator.advance(time, senses):
            found += edges
        for at, robot, twist in orders:
            if at == time:
                simulator.send(robot, twist, at)
    return found


def check(edges: list[Edge], *expected: tuple[str, bool, float]) -> None:
    """Compare edges with these: sense, value, and time, within three steps."""
    found = [(" ".join(edge.what), edge.value) for edge in edges if isinstance(edge.what, RobotSense)]
    assert found == [(what, value) for what, value, _ in expected]
    assert [edge.at for edge in edges] == pytest.approx([at for *_, at in expected], abs=3 * STEP)


def test_near_begins_and_ends_at_the_reach() -> None:
    simulator = stage(WALL, a=Pose())
    edges = perform(simulator, [(0.0, "a", FORWARD), (2.0, "a", BACKWARD)], ["a near"], 3.0)
    check(edges, ("a near", False, 0), ("a near", True, AT_WALL - NEAR), ("a near", False, 4 - (AT_WALL - NEAR)))


def simulated(program: str) -> Simulator:
    simulator = Simulator()
    simulator.prepare(score_of(analyze(program)), restart=True)
    return simulator


def test_the_walls_of_a_room_and_robots_that_only_stand_there_are_near() -> None:
    walls = simulated("room 8 4\na at 0 0\na $ until near forward\n")
    edges = perform(walls, [(0.0, "a", FORWARD)], ["a near"], 3.0)
    check(edges, ("a near", False, 0), ("a near", True, 4 - 0.3 - 2))
    standing = simulated("a at 0 0\nb at 3 0 facing 90\na $ until near forward\n")
    edges = perform(standing, [(0.0, "a", FORWARD)], ["a near"], 3.0)
    check(edges, ("a near", False, 0), ("a near", True, 3 - 0.6 - 2))


@pytest.mark.parametrize("room", ["room 0.1 0.1", "room 0.0001 1000", "room 1 1"])
def test_a_room_smaller_than_its_robots_stalls_nothing(room: str) -> None:
    simulator = simulated(f"{room}\na b c d $ forward\ne at 9 9\n")
    perform(simulator, [(0.0, "a", FORWARD)], ["a near"], 2.0)
    assert all(math.isfinite(number) for pose in simulator.poses().values() for number in (pose.x, pose.y))


def test_frames_change_nothing() -> None:
    world = World(size=(6, 6), circles=(Circle(1.5, 0.2, 0.3),), boxes=(Box(-1, 1.5, 0.7, 0.7, 0.4),))
    orders = [(0.0, "a", Twist(x=1.0, yaw=0.7)), (0.0, "b", Twist(x=0.8, yaw=-0.5)), (4.0, "a", TURN)]
    asked = ["a near", "a bump", "b near", "b bump"]

    def edges(frame: float) -> list[Edge]:
        return perform(stage(world, a=Pose(), b=Pose(-1, -1)), orders, asked, 8.0, frame)

    found = edges(1 / 240)
    assert found == edges(1 / 7) == edges(10.0)
    assert len(found) > 10
    assert all(edge.at * STEPS_PER_SECOND == pytest.approx(round(edge.at * STEPS_PER_SECOND)) for edge in found)


@pytest.mark.parametrize(("z", "near"), [(0.5, True), (0.7, False)])
def test_a_robot_flying_above_another_is_not_near(z: float, near: bool) -> None:
    simulator = stage(World(), a=Pose(), b=Pose(1.0, z=z))
    check(perform(simulator, [], ["a near"], 0.1), ("a near", near, 0))


def test_a_bump_lasts_until_the_robot_moves_away() -> None:
    """While it stands against the wall, the bump lasts, so that a program can read it afterward; turning away ends
    it."""
    simulator = stage(WALL, a=Pose())
    orders = [(0.0, "a", FORWARD), (3.0, "a", STILL), (4.0, "a", TURN), (5.0, "a", FORWARD)]
    edges = perform(simulator, orders, ["a bump"], 6.0)
    check(edges, ("a bump", False, 0), ("a bump", True, AT_WALL), ("a bump", False, 4.0))
    assert simulator.poses()["a"].x == pytest.approx(AT_WALL - 1, abs=0.01)


@pytest.mark.parametrize(
    ("source", "at"),
    [
        (Topic("/a/scan", "sensor_msgs/LaserScan", below=1.0, start=-0.5, end=0.5), 2.0),
        (Topic("/a/scan", "sensor_msgs/LaserScan", below=1.0, start=1.3, end=2.0), None),
        (Topic("/a/scan", "sensor_msgs/LaserScan", above=1.0, start=-0.5, end=0.5), -2.0),
        (Topic("/a/range", "sensor_msgs/Range", below=0.6), 2.4),
        (Topic("/a/hit", "std_msgs/Bool"), None),
        (Topic("/a/volts", "std_msgs/Float32", above=0.0), None),
    ],
    ids=str,
)
def test_declared_sensors_measure_the_scene(source: Topic, at: float | None) -> None:
    """At a negative time, the sense becomes false. Senses that the simulator can't know are false."""
    edges = perform(stage(WALL, {"sight": source}, a=Pose()), [(0.0, "a", FORWARD)], ["a sight"], 2.6)
    expected = [("a sight", at is not None and at < 0, 0.0)]
    check(edges, *expected, *([("a sight", at > 0, abs(at))] if at else []))


def test_a_declared_sense_replaces_a_built_in_one() -> None:
    scanner = Topic("/a/scan", "sensor_msgs/LaserScan", below=2.0)
    edges = perform(stage(WALL, {"near": scanner}, a=Pose()), [(0.0, "a", FORWARD)], ["a near"], 2.0)
    check(edges, ("a near", False, 0), ("a near", True, 1.0))
    switch = Topic("/a/hit", "std_msgs/Bool")
    edges = perform(stage(WALL, {"near": switch}, a=Pose()), [(0.0, "a", FORWARD)], ["a near"], 2.0)
    check(edges, ("a near", False, 0), ("a near", True, AT_WALL - NEAR))


@pytest.mark.parametrize("dynamics", ["ideal", "motors"])
def test_odometry_measures_speed(dynamics: str) -> None:
    source = Topic("/a/odom", "nav_msgs/Odometry", above=0.5)
    simulator = stage(World(), {"moves": source}, replace(DISC, dynamics=dynamics), a=Pose())
    edges = perform(simulator, [(0.5, "a", FORWARD), (2.0, "a", TURN)], ["a moves"], 3.0)
    late = 0.5 if dynamics == "motors" else 0.0  # at 1 m/s²
    check(edges, ("a moves", False, 0), ("a moves", True, 0.5 + late), ("a moves", False, 2.0 + late))


def test_asking_again_gives_the_current_value() -> None:
    simulator = stage(WALL, a=Pose())
    near, bump = RobotSense("a", "near"), RobotSense("a", "bump")
    assert simulator.advance(0.5, {near}) == [Edge(near, False, 0.0)]
    simulator.send("a", FORWARD, 0.0)
    assert simulator.advance(0.5, {bump}) == [Edge(bump, False, 0.0)]
    assert simulator.advance(2.0, {bump}) == []
    assert simulator.advance(2.0, {bump, near}) == [Edge(near, True, 2.0)]
    simulator.place({"a": Pose(-9.0)})
    assert simulator.advance(2.1, {near}) == [Edge(near, False, 2.0)]
    assert simulator.advance(2.1, {near}) == []


def test_senses_change_no_movement() -> None:
    orders = [(0.0, "a", Twist(x=1.0, yaw=0.3)), (0.0, "b", Twist(x=0.5, yaw=-1.0))]
    poses, bumps = [], list[Bump]()
    for asked in ([], ["a near", "b near", "a bump"]):
        simulator = stage(World(size=(5, 5)), a=Pose(), b=Pose(1, 1))
        perform(simulator, orders, asked, 5.0)
        poses.append(simulator.poses())
        bumps += simulator.snapshot().bumps
    assert bumps
    assert poses[0] == poses[1]
