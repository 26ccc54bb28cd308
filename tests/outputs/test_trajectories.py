"""Commands for controllers of joints: which controllers get them, and how a course becomes a trajectory that ends at
rest."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from random import Random

import pytest

from improv_core.outputs.cdr import numbers_message, trajectory_message
from improv_core.outputs.ros.joints.channels import (
    LONGEST_WINDOW,
    WINDOW,
    Channel,
    channels_of,
    joint_states_of,
    needs_base,
    window_of,
)
from improv_core.outputs.ros.joints.trajectories import (
    CRUISE,
    SOONEST_STOP,
    Course,
    current_course,
    homing_channel,
    homing_course,
    let_go,
    message_of,
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
from tests.outputs.dances import REPEAT, dance, steepest
from tests.ros.controller import TrajectoryController

YAW, PITCH = Joint("yaw", -2.0, 2.0, max_velocity=4.0), Joint("pitch", None, 1.0)
HEAD = Channel((YAW, PITCH), "trajectory", "/ada/head")


def course(*motions: tuple[float, float], since: float = 0.0, until: float = math.inf) -> Course:
    return Course(tuple(JointMotion(*motion) for motion in motions), since, until=until)


def told(**motions: tuple[float, float]) -> dict[str, JointMotion]:
    """The places of joints in the program, and their velocities."""
    return {name: JointMotion(*motion) for name, motion in motions.items()}


@pytest.mark.parametrize(
    ("before", "what", "at", "after"),
    [
        (course((0, 0), (0, 0)), told(yaw=(0, 1)), 5, course((0, 1), (0, 0), since=5)),
        (course((0, 1), (0, 0), until=0.1), told(yaw=(0.1, 0)), 0.1, course((0.1, 0), (0, 0), since=0.1)),
        (course((0, 1), (0, 0)), told(pitch=(0, -1)), 0.1, course((0.1, 1), (0, -1), since=0.1)),  # another part's
        (course((0, 1), (0, -1)), told(yaw=(0.2, -1)), 0.2, course((0.2, -1), (-0.2, -1), since=0.2)),
        (course((1.9, 1), (0, 0)), {}, 0.2, course((2, 0), (0, 0), since=0.2)),  # it reaches its limit by itself
        (course((2, 0), (0, 0)), told(yaw=(2, 1)), 1, course((2, 0), (0, 0), since=1)),
        (course((2, 0), (0, 0)), told(yaw=(2, -1)), 1, course((2, -1), (0, 0), since=1)),
        (course((2.5, 0), (0, 0)), told(yaw=(2, -1)), 1, course((2.5, -1.5), (0, 0), since=1)),  # no jump back
        (course((2.5, 0), (0, 0)), told(yaw=(2, 1)), 1, course((2.5, 0), (0, 0), since=1)),
        (course((0, 0), (0, 0)), told(yaw=(0, 9)), 1, course((0, 4), (0, 0), since=1)),  # at most its highest speed
        (course((0, 0), (0, 0)), told(yaw=(0, -9), pitch=(0, -9)), 1, course((0, -4), (0, -9), since=1)),
        (course((0, 1), (0, 0), since=8), told(yaw=(0, 1)), 0, course((0, 1), (0, 0), since=0)),  # time starts over
        (course((0.5, 1), (0, 0), since=1), told(yaw=(0.499, -1)), 0.999, course((0.5, -1.5), (0, 0), since=1)),
    ],
)
def test_commands_move_joints_within_their_limits(
    before: Course, what: dict[str, JointMotion], at: float, after: Course
) -> None:
    assert turned(HEAD, before, what, at) == after


def points(*motions: tuple[float, float]) -> list[tuple[float, list[float], list[float]]]:
    return [*map(tuple, trajectory(HEAD, course(*motions)))]  # type: ignore[list-item]


def test_a_joint_speeds_up_cruises_and_comes_to_rest() -> None:
    found = points((0, 1), (0.5, 0))
    assert [seconds for seconds, _, _ in found] == pytest.approx([WINDOW, CRUISE, CRUISE + WINDOW])
    assert [positions for _, positions, _ in found] == [[pytest.approx(each), 0.5] for each in (0.05, 0.15, 0.2)]
    assert [velocities for _, _, velocities in found] == [[pytest.approx(each), 0] for each in (1, 1, 0)]


def test_joints_that_stand_have_a_single_point_that_is_not_at_time_0() -> None:
    """A controller would jump to a point for the present if its joints lag."""
    ((seconds, positions, velocities),) = points((0.1, 0), (0.5, 0))
    assert [seconds, *positions, *velocities] == pytest.approx([0.05, 0.1, 0.5, 0, 0])


@pytest.mark.parametrize("until", [0.001, 0.003, 0.05, 0.2, 0.5])
def test_no_point_lies_beyond_the_place_where_joints_change_next(until: float) -> None:
    """They may turn around there, even if that command is late or gets lost."""
    begun = turned(HEAD, course((0, 0), (0, 0)), told(yaw=(0, 1), pitch=(0, -2)), 0.0)
    found = [*trajectory(HEAD, turned(HEAD, begun, {}, 0.15, until=0.15 + until))]
    assert found[0].seconds >= 0.02 - 1e-9
    end = 0.15 + min(until, CRUISE)
    assert found[-1].positions == pytest.approx([end, -2 * end])
    assert all(each.positions[0] <= end + 1e-9 and each.positions[1] >= -2 * end - 1e-9 for each in found)


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


@pytest.mark.parametrize("cruised", [False, True])
@pytest.mark.parametrize("pitch", [0.0, -3.0, 1e-9])
@pytest.mark.parametrize("yaw", STATES)
def test_between_its_points_a_trajectory_passes_no_limit_and_keeps_speeds_and_accelerations(
    yaw: tuple[float, float], pitch: float, cruised: bool
) -> None:
    stood = course((yaw[0], 0), (0.95, 0))
    moving = turned(HEAD, stood, told(yaw=yaw, pitch=(0.95, pitch)), 0.0)
    begin = turned(HEAD, moving, {}, 0.15) if cruised else moving
    made = TrajectoryController(["yaw", "pitch"], [each.position for each in stood.motions])
    if cruised:  # as it was sent before
        made.take(["yaw", "pitch"], [*trajectory(HEAD, moving)], 99.85)
    made.take(["yaw", "pitch"], [*trajectory(HEAD, begin)], 100.0)
    assert not made.refused
    limits = [(min(-2, yaw[0]), max(2, yaw[0])), (-math.inf, 1)]
    last = made.states(100.0)
    for tick in range(1, 500):
        now = made.states(100 + tick / 1000)
        for (position, velocity), (_, earlier), asked, (least, greatest) in zip(
            now, last, (yaw[1], pitch), limits, strict=True
        ):
            assert least - 1e-9 <= position <= greatest + 1e-9
            assert abs(velocity) <= abs(asked) + 1e-9
            assert abs(velocity - earlier) * 1000 <= abs(asked) / WINDOW * 1.01 + 1e-9
        last = now
    assert all(velocity == 0 for _, velocity in last)


def test_on_a_slower_clock_joints_are_faster_and_arrive_as_soon() -> None:
    """A simulation runs at half speed: by its time, joints move twice as fast."""
    moving = course((0, 0.5), (0, 0))
    sent = [
        (each.seconds / 2, each.positions, [0.0 + 2 * speed for speed in each.velocities])
        for each in trajectory(HEAD, moving)
    ]
    assert message_of(HEAD, moving, 0.5) == trajectory_message(("yaw", "pitch"), sent)
    assert message_of(Channel((YAW, PITCH), "velocity", "/t"), moving, 0.5) == numbers_message([1, 0])


PROGRAM = [(1.0, (1.0, 0.0)), (1.05, (1.0, 0.0)), (1.1, (1.0, -2.0)), (1.15, (-3.0, -2.0)), (1.3, (0.0, 0.0))]
"""The velocities of yaw and pitch from a time on. Their places at the end are -0.3 and -0.4."""


@pytest.mark.parametrize("window", [WINDOW, 0.5])
@pytest.mark.parametrize("late", [0.0, 0.004])
@pytest.mark.parametrize("begin", [0.0, 4321.1, 777.777, 1e5 / 3])
def test_joints_arrive_where_they_are_sent_within_their_accelerations(begin: float, late: float, window: float) -> None:
    """Times are rounded, and every other command leaves late. Joints that state no acceleration catch up with more."""
    danced = dance(replace(HEAD, window=window), PROGRAM, lambda number: late * (number % 2), begin)
    assert [position for position, _ in danced[-1]] == pytest.approx([-0.3, -0.4])
    most = 2.0 if late else 1.01
    assert steepest(danced, 0) <= 4 / window * most
    assert steepest(danced, 1) <= 2 / window * most


KEPT = Joint("yaw", max_velocity=1.0, max_acceleration=4.0)
NOD = Channel((KEPT,), "trajectory", "/ada/head", window=0.25)
"""It may reverse from 0.5 rad/s."""
BACK_AND_FORTH = [(1.0, [0.5]), (2.0, [-0.5]), (3.0, [0.5]), (4.0, [-0.5]), (5.0, [0.0])]


@pytest.mark.parametrize("late", [0.0, 0.003])
@pytest.mark.parametrize("seed", [9, 21, 42, 48, 55])
def test_joints_keep_their_accelerations_although_some_change_right_before_others(seed: int, late: float) -> None:
    """No point can lie so soon, where a joint's acceleration changes. Every other message leaves late."""
    joints, dice = [replace(KEPT, name=name, max_velocity=0.5) for name in ("yaw", "pitch")], Random(seed)
    program, at, speeds = [], 1.0, [0.5, 0.5]
    while at < 3.0:
        speeds = [dice.choice((0.5, -0.5)) if dice.random() < 0.7 else speed for speed in speeds]
        program.append((at, speeds))
        at += dice.uniform(0.03, 0.4)
    head = replace(NOD, joints=tuple(joints))
    danced = dance(head, [*program, (at, [0.0, 0.0])], lambda number: late * (number % 2))
    assert max(steepest(danced, joint) for joint in range(2)) <= 4.0 * 1.05


@pytest.mark.parametrize("delay", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("period", [1, 2, 7])
def test_late_messages_ask_for_no_larger_accelerations(delay: float, period: int) -> None:
    """Joints have come to rest at the place where they turn, as they were sent. From there, they catch up."""
    danced = dance(NOD, BACK_AND_FORTH, lambda number: delay * (number % period == 0), seconds=6.0)
    assert steepest(danced, 0) <= 4.0 * 1.02
    assert danced[-1][0][0] == pytest.approx(0.0, abs=1e-5)
    assert all(-1e-6 <= position <= 0.5 + 1e-6 for ((position, _),) in danced), "no farther than the program"


def test_a_joint_is_back_on_the_program_soon_after_late_messages() -> None:
    """Nothing leaves for 0.2 s after the joint has turned. It meets the program where it turns next."""
    late = lambda number: max(0.2 - (number - 20) * REPEAT, 0.0) if number >= 20 else 0.0  # noqa: E731
    danced, on_time = (dance(NOD, BACK_AND_FORTH, each, seconds=6.0) for each in (late, lambda number: 0.0))
    off = [abs(one[0] - other[0]) for (one,), (other,) in zip(danced, on_time, strict=True)]
    assert 0.05 < max(off[:2000]) < 0.11
    assert max(off[2700:]) < 1e-6


@pytest.mark.parametrize(
    ("channel", "stop", "seconds"),
    [
        (NOD, 1.5, 0.125),  # from 0.5 rad/s with 4 rad/s²
        (NOD, 1.02, SOONEST_STOP),
        (NOD, 2.05, 0.075),  # while it turns around
        (replace(NOD, window=2.0), 1.9, 0.056),  # another joint of the controller needs that window
        (replace(NOD, joints=(replace(KEPT, max_acceleration=None),)), 1.5, WINDOW),
        (replace(NOD, joints=(replace(KEPT, max_acceleration=0.1),), window=2.0), 1.9, 1.0),
    ],
)
def test_a_stop_brakes_as_fast_as_a_joint_may(channel: Channel, stop: float, seconds: float) -> None:
    (_, before), *after = [each[0] for each in dance(channel, BACK_AND_FORTH, stop=stop)[round(stop * 1000) - 1000 :]]
    assert before
    moving = sum(1 for _, velocity in after if velocity)
    assert moving / 1000 == pytest.approx(seconds, abs=0.003)
    assert all(abs(velocity) <= abs(before) + 1e-9 for _, velocity in after)
    limit = channel.joints[0].max_acceleration or 0.5 / WINDOW
    steepest = max(abs(one - other) * 1000 for (_, one), (_, other) in pairwise([(0.0, before), *after]))
    assert steepest <= max(limit, 0.5 / seconds) * 1.05


def test_a_joint_that_was_held_catches_up_while_it_moves_but_never_at_rest() -> None:
    """A person has held it 0.5 rad below the program. Once the program lets it rest, people may be near."""
    behind = course((0.0, 0.0), (0, 0))
    up = turned(HEAD, behind, told(yaw=(0.5, 1.0)), 1.0, until=2.0)
    assert up.velocities == [1.5, 0]
    down = turned(HEAD, behind, told(yaw=(0.5, -1.0)), 1.0, until=2.0)
    assert down.velocities == [-0.5, 0]
    assert [each.since for each in turned(HEAD, behind, told(yaw=(0.05, -1.0)), 1.0, until=2.0).legs][-1] == 1.1
    assert turned(HEAD, up, told(yaw=(0.8, 0.0)), 2.0).velocities == [0, 0], "far from there"
    assert turned(HEAD, up, told(yaw=(0.35, 0.0)), 2.0).velocities == [1.5, 0], "it only has to arrive"
    assert turned(HEAD, up, told(yaw=(0.35, 0.0)), 1.1, until=1.1).velocities == [0, 0], "a stop"
    assert turned(HEAD, behind, told(yaw=(0.05, 0.0)), 1.0).velocities == [0, 0]
    assert turned(replace(HEAD, interface="velocity"), behind, told(yaw=(0.5, 1)), 1.0).velocities == [1, 0]


FAST = """
[profiles.nao.joints.yaw]
min = -90
max_acceleration = 120
"""


@pytest.mark.parametrize(
    ("program", "toml", "window"),
    [
        ("ada $ head (left right)", "", 0.5),  # from 30 to -30°/s
        ("beat 120\nada $ head (left right)", "", 1.0),
        ("ada $ head (left right)\n---\nada $ head fast 2 left", "", 1.0),
        ("ada $ head (left right)", "max_velocity = 15", 0.25),
        ("ada $ head up", "", WINDOW),
        ("ada $ arm up", "", WINDOW),
        ("ada $ head to start", "max_velocity = 60", 1.0),
        ("ada $ head fast 9 left", "", LONGEST_WINDOW),
    ],
)
def test_joints_are_smoothed_as_long_as_their_accelerations_need(program: str, toml: str, window: float) -> None:
    part = part_of(f"{program}\n", TOML.replace("[profiles.nao.joints.yaw]\nmin = -90\n", FAST + toml + "\n"))
    tempo = Fraction(120 if program.startswith("beat") else 60)
    (channel,) = channels_of(part)
    assert window_of(part, channel, tempo) == pytest.approx(window)


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
    found, expected = let_go(HEAD, before, now, measured), after or now
    assert [*map(tuple, found.motions)] == [pytest.approx(each) for each in expected.motions]


def test_messages_have_the_positions_of_a_joints_encoders() -> None:
    joints = replace(YAW, offset=0.5), PITCH
    motions = course((1, 2), (0.5, 0))
    positions, velocities = [0.5, 0.5], [2, 0]
    assert message_of(Channel(joints, "position", "/t"), motions) == numbers_message(positions)
    assert message_of(Channel(joints, "velocity", "/t"), motions) == numbers_message(velocities)
    stands = course((1, 0), (0.5, 0))
    assert message_of(Channel(joints, "trajectory", "/t"), stands) == trajectory_message(
        ("yaw", "pitch"), [(0.05, positions, [0, 0])]
    )


def test_joints_move_to_their_starts_at_a_fifth_of_their_speed_and_stop_there() -> None:
    """Pitch is at its start, and has no highest speed."""
    joints = replace(YAW, start=-0.5), PITCH
    channel, now = Channel(joints, "trajectory", "/t"), course((0.3, 0), (0, 0))
    way = homing_channel(channel, now)
    assert way
    now = homing_course(way, now, 7.0)
    assert now == course((0.3, -0.8), (0, 0), since=7)
    for at in (7.2, 7.4, 7.6):
        now = turned(way, now, {}, at)
    assert [*now.motions[0]] == pytest.approx([-0.18, -0.8])
    assert [*stopped(way, now, 0.1).motions[0]] == pytest.approx([-0.26, 0])
    for at in (7.8, 7.9):
        now = turned(way, now, {}, at)
    last = [*trajectory(way, now)][-1]
    assert [*last.positions, *last.velocities] == pytest.approx([-0.5, 0, 0, 0])
    assert last.seconds < CRUISE + WINDOW
    assert turned(way, now, {}, 8.1) == course((-0.5, 0), (0, 0), since=8.1)


def test_some_joints_have_no_way_home() -> None:
    """They lack a highest speed, or have a velocity controller, which doesn't stop by itself."""
    assert homing_channel(HEAD, course((0, 0), (0.1, 0))) is None
    assert homing_channel(Channel((YAW,), "velocity", "/t"), Course((JointMotion(0.1, 0),))) is None
