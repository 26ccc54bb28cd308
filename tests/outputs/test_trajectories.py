"""Commands for controllers of joints: which controllers get them, and how a course becomes a trajectory that ends at
rest."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from improv_core.outputs.cdr import numbers_message, trajectory_message
from improv_core.outputs.ros.joints.trajectories import (
    CRUISE,
    HORIZON,
    Channel,
    Course,
    channels_of,
    current_course,
    homing_channel,
    homing_course,
    joint_states_of,
    let_go,
    message_of,
    needs_base,
    paced,
    standing,
    stopped,
    trajectory,
    turned,
)
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.body import Joint
from improv_core.score.joints import JointMotion
from improv_core.score.score import Part
from tests.ros.controller import TrajectoryController

YAW, PITCH = Joint("yaw", -2.0, 2.0, max_velocity=4.0), Joint("pitch", None, 1.0)
HEAD = Channel((YAW, PITCH), "trajectory", "/ada/head")


def course(*motions: tuple[float, float], since: float = 0.0) -> Course:
    return Course(tuple(JointMotion(*motion) for motion in motions), since)


def told(**motions: float) -> dict[str, JointMotion]:
    """Velocities. The positions that the stage assumes make no difference."""
    return {name: JointMotion(99.0, velocity) for name, velocity in motions.items()}


@pytest.mark.parametrize(
    ("before", "what", "at", "after"),
    [
        (course((0, 0), (0, 0)), told(yaw=1), 5, course((0, 1), (0, 0), since=5)),
        (course((0, 1), (0, 0)), told(yaw=0), 0.5, course((0.5, 0), (0, 0), since=0.5)),
        (course((0, 1), (0, 0)), told(pitch=-1), 0.5, course((0.5, 1), (0, -1), since=0.5)),  # another part's joint
        (course((0, 1), (0, -1)), told(yaw=-1, pitch=0), 1, course((1, -1), (-1, 0), since=1)),
        (course((1.5, 1), (0, 0)), {}, 3, course((2, 0), (0, 0), since=3)),  # it reaches its limit without a command
        (course((2, 0), (0, 0)), told(yaw=1), 1, course((2, 0), (0, 0), since=1)),
        (course((2, 0), (0, 0)), told(yaw=-1), 1, course((2, -1), (0, 0), since=1)),
        (course((2.5, 0), (0, 0)), told(yaw=-1), 1, course((2.5, -1), (0, 0), since=1)),  # beyond it: no jump back
        (course((2.5, 0), (0, 0)), told(yaw=1), 1, course((2.5, 0), (0, 0), since=1)),
        (course((0, 0), (0, 0)), told(yaw=9), 1, course((0, 4), (0, 0), since=1)),  # at most its highest speed
        (course((0, 0), (0, 0)), told(yaw=-9, pitch=-9), 1, course((0, -4), (0, -9), since=1)),
        (course((0, 1), (0, 0), since=8), told(yaw=1), 0, course((0, 1), (0, 0), since=0)),  # time starts over
    ],
)
def test_commands_move_joints_within_their_limits(
    before: Course, what: dict[str, JointMotion], at: float, after: Course
) -> None:
    assert turned(HEAD, before, what, at) == after


def points(*motions: tuple[float, float]) -> list[tuple[float, list[float], list[float]]]:
    return [*map(tuple, trajectory(HEAD, course(*motions)))]  # type: ignore[list-item]


def test_a_joint_cruises_and_comes_to_rest() -> None:
    (now, *_), (cruise, *_), (rest, positions, velocities) = points((0, 1), (0.5, 0))
    assert (now, cruise, rest) == (0, CRUISE, HORIZON)
    assert positions == [pytest.approx((CRUISE + HORIZON) / 2), 0.5]
    assert velocities == [0, 0]


STATES = [
    (0.0, 1.0),
    (0.0, -4.0),
    (1.9, 1.0),
    (1.79, 1.0),
    (1.78, 1.0),
    (1.9995, 4.0),
    (2.0, 1.0),
    (-1.2, -4.0),
    (2.3, -1.0),
]


@pytest.mark.parametrize("pitch", [0.0, -3.0, 1e-9])
@pytest.mark.parametrize("yaw", STATES)
def test_between_its_points_a_trajectory_passes_no_limit_and_gets_no_faster(
    yaw: tuple[float, float], pitch: float
) -> None:
    begin = turned(HEAD, course(yaw, (0.95, pitch)), {}, 0.0)
    made = TrajectoryController(["yaw", "pitch"], [9, 9])
    given = [*trajectory(HEAD, begin)]
    made.take(["yaw", "pitch"], given, 100.0)
    assert not made.refused
    fastest = [abs(motion.velocity) for motion in begin.motions]
    limits = [(min(-2, yaw[0]), max(2, yaw[0])), (-math.inf, 1)]
    for tick in range(500):
        for (position, velocity), most, (least, greatest) in zip(
            made.states(100 + tick / 1000), fastest, limits, strict=True
        ):
            assert least - 1e-9 <= position <= greatest + 1e-9
            assert abs(velocity) <= most * 4 / 3 + 1e-9  # 4/3 only if a joint reaches its limit before it can brake
    assert all(velocity == 0 for _, velocity in made.states(100 + HORIZON + 0.001))


def test_joints_are_as_fast_as_in_a_simulation_by_its_time() -> None:
    """At half speed, they move half as far in a real second, and as far in a simulated one."""
    moving = course((0, 0.5), (0, 0))
    assert paced(moving, 0.5) == course((0, 1), (0, 0))
    assert paced(turned(HEAD, moving, {}, 1.0), 0.5) == course((0.5, 1), (0, 0), since=1)
    assert paced(moving, 1) is moving


def test_a_course_agrees_with_its_trajectory() -> None:
    """The positions of a controller between two commands agree with those that Improv computes."""
    made = TrajectoryController(["yaw", "pitch"], [0, 0])
    now = standing(HEAD, {"yaw": 0, "pitch": 0})
    for at, what in [(1.0, told(yaw=1)), (1.05, {}), (1.1, told(pitch=-2)), (1.15, told(yaw=0)), (1.3, told(pitch=0))]:
        before = made.states(at)
        now = turned(HEAD, now, what, at)
        assert [position for position, _ in before] == pytest.approx([each.position for each in now.motions])
        given = [*trajectory(HEAD, now)]
        made.take(["yaw", "pitch"], given, at)
    assert [position for position, _ in made.states(9)] == pytest.approx([0.15, -0.4])


TOML = """
[profiles.nao]
step = 1
joint_states = "joint_states"
[profiles.nao.body.head]
left = { joint = "yaw", degrees = 30 }
up = { joint = "pitch", degrees = 20 }
[profiles.nao.body.arm]
up = { joint = "shoulder", degrees = 30 }
forward = { joint = "elbow", degrees = 30 }
[profiles.nao.joints.yaw]
min = -90
[robots.ada]
profile = "nao"
"""
BOTH = """
[profiles.nao.controllers.head]
joints = ["pitch", "yaw"]
[profiles.nao.controllers.arm]
joints = ["shoulder", "elbow"]
interface = "velocity"
"""


def part_of(program: str, toml: str) -> Part:
    robots = read_robots(toml)
    assert robots.ok, robots.diagnostics
    return score_of(analyze(program, robots)).parts["ada"]


def channels(program: str, toml: str) -> list[tuple[str, str, list[str]]]:
    return [
        (each.topic, each.message, [joint.name for joint in each.joints])
        for each in channels_of(part_of(f"{program}\n", toml))
    ]


ALL = ("/ada/joint_trajectory_controller/joint_trajectory", "JointTrajectory", ["yaw", "pitch", "shoulder", "elbow"])
HEADS = ("/ada/head_controller/joint_trajectory", "JointTrajectory", ["pitch", "yaw"])
ARMS = ("/ada/arm_controller/commands", "Float64MultiArray", ["shoulder", "elbow"])


@pytest.mark.parametrize(
    ("program", "toml", "found"),
    [
        ("ada $ forward", TOML, []),
        ("ada $ head left", TOML, [ALL]),
        ("ada $ head left", TOML + BOTH, [HEADS]),
        ("ada $ forward || arm up", TOML + BOTH, [ARMS]),
        ("ada $ arm up head up", TOML + BOTH, [HEADS, ARMS]),
        ("ada $ forward\n---\nada $ head up", TOML + BOTH, [HEADS]),
        ("ada $ head left", f'{TOML}namespace = "lab/nao"\n{BOTH}', [("/lab/nao" + HEADS[0][4:], *HEADS[1:])]),
        ("ada $ head left", f'[ros]\nnamespace = "lab"\n{TOML}{BOTH}', [("/lab" + HEADS[0], *HEADS[1:])]),
        ("ada $ arm up", f'{TOML}{BOTH}topic = "arms/set"\n', [("/ada/arms/set", *ARMS[1:])]),
        ("ada $ arm up", f'{TOML}{BOTH}topic = "/set"\n', [("/set", *ARMS[1:])]),
        (
            "ada $ arm up",
            f"{TOML}{BOTH}".replace("velocity", "position"),
            [("/ada/arm_controller/commands", "Float64MultiArray", ["shoulder", "elbow"])],
        ),
    ],
)
def test_only_controllers_of_moved_body_parts_are_used(
    program: str, toml: str, found: list[tuple[str, str, list[str]]]
) -> None:
    assert channels(program, toml) == found


def test_a_robot_that_only_has_to_stop_has_the_controllers_that_never_stop_by_themselves() -> None:
    part = part_of("ada $ head left\n", TOML + BOTH)
    assert [each.topic for each in channels_of(Part("ada", (), part.profile, part.start, part.topic))] == [
        "/arm_controller/commands"
    ]


@pytest.mark.parametrize(
    ("program", "needed"),
    [("ada $ forward", True), ("ada $ head left", False), ("ada $ head left forward", True), ("ada $ pause", True)],
)
def test_a_base_is_needed_unless_only_body_parts_move(program: str, needed: bool) -> None:
    part = part_of(f"{program}\n", TOML)
    assert needs_base(part) is needed
    assert joint_states_of(part) == "/ada/joint_states"


HERE = course((0.1, 0), (0.2, 0))
NOWHERE: dict[str, float] = {}


@pytest.mark.parametrize(
    ("before", "measured", "how", "after"),
    [
        (None, {"yaw": 1, "pitch": 0.5}, "", course((1, 0), (0.5, 0))),
        (None, {"yaw": 1}, "", None),
        (None, NOWHERE, "begins from measured", None),
        (HERE, {"yaw": 1, "pitch": 0.5}, "", HERE),  # an arm that hangs must not sink
        (HERE, {"yaw": 1, "pitch": 0.2}, "begins", course((1, 0), (0.2, 0))),  # a person turned it
        (HERE, {"yaw": 0.15, "pitch": 0.2}, "begins", HERE),  # it hangs by 3°
        (HERE, {"yaw": 0.15, "pitch": 0.2}, "begins from measured", course((0.15, 0), (0.2, 0))),
        (HERE, {"yaw": 0.15, "pitch": 0.2}, "from measured", course((0.15, 0), (0.2, 0))),
        (HERE, {"yaw": 1, "pitch": 0.2}, "begins from measured moved", HERE),  # it isn't at rest yet
        (HERE, NOWHERE, "begins from measured", HERE),
        (course((0, 1), (0, 0)), {"yaw": 1, "pitch": 1}, "begins from measured", course((0, 1), (0, 0))),
    ],
)
def test_a_course_starts_at_measured_or_commanded_positions(
    before: Course | None, measured: dict[str, float], how: str, after: Course | None
) -> None:
    flags = {"begins": "begins" in how, "from_measured": "from measured" in how, "rests": "moved" not in how}
    assert current_course(HEAD, before, measured, **flags) == after


@pytest.mark.parametrize(
    ("before", "now", "measured", "after"),
    [
        (course((0, 1), (0, 0)), course((0.5, 1), (0, 0)), {"yaw": (0, 0)}, None),  # it follows a moment later
        (course((0, 1), (0, 0)), course((1.9, 1), (0, 0)), {"yaw": (0.2, 0)}, course((0.2, 1), (0, 0))),
        (course((0, 1), (0, 0)), course((1.9, 0), (0, 0)), {"yaw": (0.2, 0)}, course((0.2, 0), (0, 0))),  # a stop
        (course((0, 1), (0, 0)), course((0.5, 0), (0, 0)), {"yaw": (0.1, 0)}, course((0.1, 0), (0, 0))),
        (course((0, 1), (0, 0)), course((0.5, 0), (0, 0)), {"yaw": (0.3, 0)}, None),  # it still moves on to there
        (course((0, 0), (0, 0)), course((1.9, 1), (0, 0)), {"yaw": (0.2, 0)}, course((0.2, 1), (0, 0))),
        (course((0, -1), (0, 0)), course((0, 1), (0, 0)), {"yaw": (0.3, 0)}, None),  # it hasn't reversed yet
        (course((0, 1), (0, 0)), course((1.9, 1), (0, 0)), {"yaw": (0.2, 1.5)}, None),  # that was long ago
        (course((0, 1), (0, 0)), course((1.9, 1), (0, 0)), {"pitch": (0.2, 0)}, None),  # joints that stand may hang
        (course((0, 1), (0, 0)), course((1.9, 1), (0, 0)), {}, None),
        (course((0, 1), (0, 0)), course((0, 1), (0, 0)), {"yaw": (2, 0)}, course((2, 0), (0, 0))),  # at its limit
    ],
)
def test_a_joint_that_something_held_back_continues_from_where_it_is(
    before: Course, now: Course, measured: dict[str, tuple[float, float]], after: Course | None
) -> None:
    """Otherwise it would jump when released. `measured` has each joint's position and its age in seconds."""
    assert let_go(HEAD, before, now, measured) == (after or now)


def test_messages_have_the_positions_of_a_joints_encoders() -> None:
    joints = replace(YAW, offset=0.5), PITCH
    motions = course((1, 2), (0.5, 0))
    positions, velocities = [0.5, 0.5], [2, 0]
    assert message_of(Channel(joints, "position", "/t"), motions) == numbers_message(positions)
    assert message_of(Channel(joints, "velocity", "/t"), motions) == numbers_message(velocities)
    stands = course((1, 0), (0.5, 0))
    assert message_of(Channel(joints, "trajectory", "/t"), stands) == trajectory_message(
        ("yaw", "pitch"), [(0, positions, [0, 0])]
    )


def test_joints_move_to_their_starts_at_a_fifth_of_their_speed_and_stop_there() -> None:
    """Pitch is at its start, and has no highest speed."""
    joints = replace(YAW, start=-0.5), PITCH
    channel, now = Channel(joints, "trajectory", "/t"), course((0.3, 0), (0, 0))
    way = homing_channel(channel, now)
    assert way
    now = homing_course(way, now, 7.0)
    assert now == course((0.3, -0.8), (0, 0), since=7)
    now = turned(way, now, {}, 7.5)
    assert [*now.motions[0]] == pytest.approx([-0.1, -0.8])
    last = [*trajectory(way, turned(way, now, {}, 7.9))][-1]
    assert [*last.positions, *last.velocities] == pytest.approx([-0.5, 0, 0, 0])
    assert last.seconds < HORIZON
    assert turned(way, now, {}, 9.0) == course((-0.5, 0), (0, 0), since=9)
    assert [*stopped(way, now, 0.25).motions[0]] == pytest.approx([-0.3, 0])


def test_some_joints_have_no_way_home() -> None:
    """They lack a highest speed, or have a velocity controller, which doesn't stop by itself."""
    assert homing_channel(HEAD, course((0, 0), (0.1, 0))) is None
    assert homing_channel(Channel((YAW,), "velocity", "/t"), Course((JointMotion(0.1, 0),))) is None
