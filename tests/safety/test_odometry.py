"""The deviation of robots: poses in any frame are moved to the world of the score, and compared with the ideal path."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any, get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.player import Player
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.errors import Errors, error
from improv_core.protocol.limits import MEASURED_AT_REST
from improv_core.protocol.messages import FromStage
from improv_core.protocol.output import Noticed, RawJoints, RawPose
from improv_core.robots.config import read_robots
from improv_core.safety.odometry import CONTINUOUS, DOUBTFUL, Odometry
from improv_core.score.faults import Fault, FaultRules, Response
from improv_core.score.following import OLDEST
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import TURTLEBOT3_BURGER, TURTLESIM
from improv_core.score.score import OdomFrame, Part, Safety
from improv_core.stage.dry_run import perform
from tests.player.plays import to_play
from tests.player.test_player import Stage, score

ODOMETRY, LOCALIZATION = CONTINUOUS, "geometry_msgs/PoseWithCovarianceStamped"
FRAME = Pose(5, -3, 0, 2.5)
"""The origin of the world in the frame of the source."""
PROGRAM = "beat 60\nr $ forward left forward\n"


class Robot:
    """A stage with real robots of which `r` is measured every 50 ms: `off` is its pose in the world."""

    def __init__(self, source: str = ODOMETRY, frame: Pose = FRAME, odom_frame: OdomFrame = "own") -> None:
        self.stage = Stage()
        self.stage.sink.real = True
        self.source, self.frame, self.odom_frame = source, frame, odom_frame

    @property
    def player(self) -> Player:
        return self.stage.player

    def play(
        self,
        program: str = PROGRAM,
        when: Any = "restart",
        *,
        rules: FaultRules | None = None,
        anyway: bool = False,
        follow: bool = False,
        use_sim_time: bool = False,
    ) -> None:
        read = score(program)
        how: dict[str, Any] = {"odom_frame": self.odom_frame, "follow": follow, "use_sim_time": use_sim_time}
        parts = {name: replace(part, odom=f"/{name}/odom", **how) for name, part in read.parts.items()}
        read = replace(read, parts=parts, safety=Safety(faults=rules or FaultRules()))
        self.stage.request(to_play(read, len(self.stage.told) + 1, when, anyway=anyway))

    def run(self, seconds: float) -> None:
        self.stage.run(seconds)

    def pose(self, world: Pose, ago: float = 0.0) -> dict[str, Any] | None:
        before = len(self.measured)
        raw = RawPose("r", self.source, self.frame.then(world), self.stage.now - ago)
        self.player.measure([raw], self.stage.now)
        return self.measured[-1]["robots"]["r"] if len(self.measured) > before else None

    def drive(self, seconds: float, age: float | None = None) -> None:
        """Drive along the x axis at 2 m/s, to the ideal distance at this time; poses are stamped `age` seconds before
        they come."""
        for _ in range(round(seconds / 0.05)):
            at = self.stage.now
            place = self.frame.then(Pose(2 * (at - 1000)))
            stamp = None if age is None else at - age
            self.player.measure([RawPose("r", self.source, place, at, stamp=stamp)], at)
            self.run(0.05)

    def off(self, world: Pose, ago: float = 0.0) -> tuple[float, float]:
        """Return the reported deviation of a pose in meters and degrees."""
        told = self.pose(world, ago)
        assert told
        found = error(told["pose"], told["ideal"])
        return round(found.distance, 6), round(math.degrees(found.turn), 6)

    @property
    def measured(self) -> list[Any]:
        return [message for message in self.stage.told if message["type"] == "measured"]

    @property
    def lines(self) -> list[str]:
        return [message["message"] for message in self.stage.told if message["type"] in ("warning", "fault")]


def test_a_robot_is_compared_with_where_it_ideally_is_until_it_has_come_to_rest() -> None:
    robot = Robot()
    robot.play()
    assert robot.off(Pose()) == (0, 0)
    robot.run(0.5)
    assert robot.off(Pose(0.9, 0.1)) == (round(math.hypot(0.1, 0.1), 6), 0)
    robot.run(1)
    assert robot.off(Pose(2, 0, 0, math.radians(40))) == (0, 5)
    robot.run(1.5)
    assert robot.off(Pose(2, 2, 0, math.radians(90 - 360))) == (0, 0)
    assert robot.stage.states[-1] == "ended"
    robot.run(MEASURED_AT_REST)
    assert robot.pose(Pose(9)) is None


def test_a_robot_begins_where_it_stood_shortly_before_beat_0() -> None:
    robot = Robot()
    robot.stage.sink.resets = True
    robot.play()
    robot.run(1)
    assert robot.pose(Pose()) is None
    robot.run(0.05)
    robot.stage.sink.resets = False
    robot.run(0.1)  # since the latest pose, 0.1 s have passed, of which it has played nearly all
    assert robot.off(Pose()) == pytest.approx((0.2, 0), abs=0.03)
    robot.play()
    robot.run(OLDEST + 0.1)  # no pose came in time: it counts as being at its ideal pose
    assert robot.off(Pose()) == (0, 0)


def test_a_pose_counts_from_when_it_came() -> None:
    robot = Robot()
    robot.play()
    robot.pose(Pose())
    robot.run(1.1)
    assert robot.off(Pose(1.8), ago=0.2) == (0, 0)
    assert robot.off(Pose(2, 0, 0, math.radians(4.5)), ago=0.05) == (0, 0)
    assert robot.pose(Pose(1.8), ago=0.1) is None  # older than the latest report


def test_after_a_seek_a_robot_counts_as_being_where_the_score_puts_it() -> None:
    robot = Robot()
    robot.play()
    robot.pose(Pose())
    robot.run(0.5)
    first = robot.pose(Pose(1, 0.3))
    robot.stage.ask("seek", beat=2)
    robot.run(0.05)
    sought = robot.pose(Pose(1, 0.3))
    assert first
    assert sought
    assert sought["aligned"] == first["aligned"] + 1
    assert error(sought["pose"], {"x": 2, "y": 0, "z": 0, "heading": math.pi / 2}) == pytest.approx((0, 0))
    robot.run(0.45)
    assert robot.off(Pose(2, 0.3)) == (0, 0)


def test_a_pose_in_the_world_is_taken_as_it_is() -> None:
    robot = Robot(frame=Pose(), odom_frame="world")
    robot.play(anyway=True)
    assert robot.off(Pose(0.36)) == (0.36, 0)
    robot.run(1)
    assert robot.off(Pose(2.36)) == (0.36, 0)
    robot.stage.ask("seek", beat=2)
    robot.stage.ask("resume", anyway=True)
    robot.run(0.05)
    sought = robot.pose(Pose(2.36))
    assert sought
    assert error(sought["pose"], {"x": 2.36, "y": 0, "z": 0, "heading": 0}) == pytest.approx((0, 0))
    robot.run(0.05)
    assert robot.off(Pose(9))[0] > 6.9
    assert [line for line in robot.lines if "off its path" not in line] == []


@pytest.mark.parametrize(("source", "off"), [(ODOMETRY, 0.2), (LOCALIZATION, 7.98)])
def test_odometry_that_jumps_has_started_over_but_localization_has_corrected_itself(source: str, off: float) -> None:
    robot = Robot(source, frame=Pose())
    robot.play()
    robot.pose(Pose())
    robot.run(0.95)
    robot.pose(Pose(1.8))
    robot.run(0.05)
    assert robot.off(Pose(-5.98)) == (off, 0)
    robot.run(0.2)
    line = "beat 2: the pose of r jumped by 7.78 m: unless somebody moved it, check the node that publishes on /r/odom"
    assert line in robot.lines


def test_a_reset_between_two_performances_does_not_count_as_a_jump() -> None:
    robot = Robot()
    robot.play()
    robot.pose(Pose())
    robot.run(3)
    robot.pose(Pose(2, 2, 0, math.pi / 2))
    robot.play()
    robot.run(0.05)
    assert robot.off(Pose()) == (0, 0)
    assert not [line for line in robot.lines if "jump" in line]


def test_a_stop_before_the_first_score_simulates_nothing() -> None:
    simulator = Simulator(period=None)
    Player(simulator, lambda message: None, lambda: 0.0).take({"type": "stop"}, 3600.0)
    assert simulator.snapshot().at == 0, "an hour since the machine was started would take long"


def test_simulated_robots_are_measured_in_their_world() -> None:
    worn = "[profiles.worn]\nstep = 2\ndynamics = 'motors'\nwheel_error = [0.96, 0.94]\n"
    robots = worn + "[robots.r]\nprofile = 'worn'\nodom = 'odom'\nstart = { x = 3 }\n[robots.exact]\nodom = 'odom'\n"
    analysis = analyze("beat 60\nr exact $ repeat 2 (forward left)\n", read_robots(robots))
    simulator, errors, count = Simulator(period=None), Errors(), 0

    def tell(message: FromStage) -> None:
        nonlocal count
        if message["type"] == "measured":
            errors.take(message)
            count += 1

    perform(score_of(analysis), simulator, tell=tell)
    ideal = Pose(5, 2, 0, math.pi)
    largest, last = errors.robots["r"]
    ended = simulator.poses()["r"]
    assert last.distance == pytest.approx(math.dist((ended.x, ended.y), (ideal.x, ideal.y)), abs=0.01)
    assert largest.distance > 0.1
    assert errors.robots["exact"][0] == pytest.approx((0, 0), abs=1e-9)
    assert 4 * 15 < count <= 5 * 20


class Follower(Robot):
    """A burger that follows its path: the factor of its velocities is 1 while nothing is corrected."""

    def play(self, program: str = "beat 60\nr $ forward rest forward\n", when: Any = "restart", **_: Any) -> None:
        (part,) = score(program).parts.values()
        part = replace(part, odom="/r/odom", follow=True, profile=TURTLEBOT3_BURGER)
        self.stage.request(to_play(replace(score(program), parts={"r": part}), 1, when))

    @property
    def sent(self) -> list[tuple[float, float]]:
        """Return the times at which the robot's speed changed, and the new speeds."""
        found: list[tuple[float, float]] = []
        for _, at, twist in self.stage.sink.sent:
            if not found or found[-1][1] != round(twist.x, 6):
                found.append((round(at, 6), round(twist.x, 6)))
        return found


def test_a_robot_that_follows_is_pulled_back_and_changes_keep_their_times() -> None:
    robot = Follower()
    robot.play()
    assert robot.pose(Pose())
    robot.run(0.49)
    told = robot.pose(Pose(0.49 * 0.2 - 0.005))
    assert told
    assert told["follows"]
    robot.run(3)
    (first, slow), (at, faster), (_, again), (second, rest), (third, x), *ends = robot.sent
    assert (first, slow, second, rest, third, x) == (0, 0.2, 1, 0, 2, 0.2)
    assert 0.49 < at < 0.55
    assert (faster, again) == (0.21, 0.2)  # 5 mm behind: 10 mm/s faster, as long as the pose is not too old
    assert ends == [(3, 0)]


def test_poses_that_are_too_old_or_too_far_off() -> None:
    robot = Follower()
    robot.play()
    robot.pose(Pose())
    robot.run(0.5)
    told = robot.pose(Pose(-9))
    assert told
    assert told["follows"]
    robot.run(2.5)
    (at, _) = robot.sent[2]
    assert [x for _, x in robot.sent] == [0.2, 0.222, 0.2, 0, 0.2, 0]
    assert 0.5 + OLDEST - 0.05 <= at <= 0.5 + OLDEST + 0.05
    rests = robot.pose(Pose(-9))
    assert rests
    assert not rests["follows"]  # it should stand


@pytest.mark.parametrize(
    ("latencies", "follows"),
    [
        ([0.05, 0.08], True),
        ([0.05, 0.21], False),  # the clocks agree, so the pose was late
        ([0.3, 0.3], False),
        ([3600.0, 3600.3], True),  # the clocks don't agree: the time of its arrival counts
        ([-0.02, -0.03], True),
        ([-9.0, -8.7], True),
    ],
)
def test_the_age_of_a_pose_is_judged_by_its_stamp_if_the_clocks_agree(latencies: list[float], follows: bool) -> None:
    robot = Follower()
    robot.play()
    for latency in latencies:
        robot.run(0.2)
        now = robot.stage.now
        place = FRAME.then(Pose(-0.005 if latency == latencies[0] else 0.0))
        robot.player.measure([RawPose("r", ODOMETRY, place, now, "", now - latency)], now)
    assert robot.measured[-1]["robots"]["r"]["follows"] == follows


def test_a_robot_on_its_path_is_not_pulled_although_its_poses_come_late() -> None:
    robot, age = Follower(), 0.08
    robot.play()
    assert robot.pose(Pose())
    robot.run(0.5)
    now = robot.stage.now
    there = FRAME.then(Pose(0.2 * (0.5 - age)))
    robot.player.measure([RawPose("r", ODOMETRY, there, now, "", now - age)], now)
    robot.run(3)
    assert robot.sent == [(0, 0.2), (1, 0), (2, 0.2), (3, 0)]


numbers = st.floats(-10, 10)


@settings(max_examples=20)
@given(x=numbers, y=numbers, heading=numbers, steps=st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), max_size=5))
def test_any_frame_is_laid_on_the_world(x: float, y: float, heading: float, steps: list[tuple[float, float]]) -> None:
    frame, start = Pose(x, y, 0, heading), Pose(y, x, 0, -heading)
    odometry = Odometry()
    odometry.begin({"r": Part("r", (), TURTLESIM, start, "/r/cmd_vel", odom="/r/odom")}, 0.0)
    world, at = start, 0.0
    odometry.take(RawPose("r", ODOMETRY, frame.then(world), at))
    for forward, turn in steps:
        twist = Twist(forward, 0, 0, turn)
        odometry.tell("r", twist, at)
        at, world = at + 0.5, world.after(twist, 0.5)
        found = odometry.take(RawPose("r", ODOMETRY, frame.then(world), at))
        assert found
        for pose in (found.pose, found.ideal):
            assert math.dist((pose.x, pose.y), (world.x, world.y)) < 1e-6
            assert math.remainder(pose.heading - world.heading, math.tau) == pytest.approx(0, abs=1e-6)


def on_faults(robot: Robot, response: Response, seconds: float) -> None:
    robot.play("beat 60\nr $ repeat forward\n", rules=FaultRules(dict.fromkeys(get_args(Fault), response)))
    robot.drive(1)
    robot.run(seconds)


def test_a_change_that_was_prepared_is_corrected_by_the_latest_pose() -> None:
    plain, prepared = Follower(), Follower()
    prepared.stage.prepares = True
    for robot in (plain, prepared):
        robot.play("beat 60\nr $ forward left\n")
        robot.pose(Pose())
        robot.run(0.97)
        robot.pose(Pose(0.97 * 0.2 - 0.005))
        robot.run(0.1)
    assert prepared.stage.sink.sent == plain.stage.sink.sent
    at, turn = next((at, twist) for _, at, twist in plain.stage.sink.sent if twist.yaw)
    assert at == 1
    assert turn.x == pytest.approx(0.01)


def corrected(odometry: Odometry, world: Pose, at: float) -> Twist:
    """Return the correction of the velocity of `r`, which drives 0.2 m/s along x from the origin, after a pose at a
    time."""
    odometry.take(RawPose("r", LOCALIZATION, world, at))
    return odometry.correction("r", Twist(0.2), at)


def following(topic: str = "/r") -> Part:
    part = score("beat 60\nr $ repeat 100 forward").parts["r"]
    return replace(
        part, odom="/pose", odom_frame="world", follow=True, profile=TURTLEBOT3_BURGER, topic=topic, start=Pose()
    )


def test_poses_that_have_jumped_correct_nothing_for_a_while() -> None:
    odometry = Odometry()
    odometry.begin({"r": following()}, 0.0)
    odometry.tell("r", Twist(0.2), 0.0)
    assert corrected(odometry, Pose(0.2, 0.05), 1.0) != STILL
    assert corrected(odometry, Pose(0.22, 1.05), 1.1) == STILL
    assert corrected(odometry, Pose(0.22 + 0.2 * (DOUBTFUL - 0.2), 1.05), 1.1 + DOUBTFUL - 0.2) == STILL
    assert corrected(odometry, Pose(0.22 + 0.2 * DOUBTFUL, 1.05), 1.1 + DOUBTFUL) != STILL


def turned_off(*, rolls: float = 1.0, late: float = 0.0, held: int = -1, step: float = 0.01) -> list[float]:
    """Return by how many degrees too little a robot has turned after each of four quarter turns. Its base `rolls` this
    share of its velocity, `late` by this many seconds, and stands in the middle of the turn `held`. Its poses are 80 ms
    old."""
    odometry, ideal, real, seen, off = Odometry(), Pose(), Pose(), deque[Pose](), list[float]()
    odometry.begin({"r": following()}, 0.0)
    sent = deque([STILL] * round(late / step))
    for count in range(4 * 400):
        now, turn = count * step, count // 400
        twist = Twist(0.1) if count % 400 < 200 else Twist(yaw=math.pi / 4)
        odometry.tell("r", twist, now)
        if count % 3 == 0 and len(seen) == 8:
            odometry.take(RawPose("r", LOCALIZATION, seen[0], now, "", now - 0.08))
        sent.append(odometry.corrected("r", twist, now))
        seen = deque([*seen, real], 8)
        is_held = turn == held and count % 400 in range(250, 340)
        real, ideal = real.after(sent.popleft().times(0 if is_held else rolls), step), ideal.after(twist, step)
        if count % 400 == 20 and turn:
            off.append(math.degrees(math.remainder(ideal.heading - real.heading, math.tau)))
    return off


@pytest.mark.parametrize(("rolls", "late"), [(0.87, 0.0), (1.1, 0.0), (1.0, 0.06), (0.87, 0.1)])
def test_a_robot_learns_from_the_ends_of_turns_to_end_the_next_ones_as_written(rolls: float, late: float) -> None:
    first, *others = turned_off(rolls=rolls, late=late)
    assert abs(first) > 1 > max(map(abs, others))


def test_a_robot_without_a_fault_has_nothing_to_learn() -> None:
    assert turned_off() == pytest.approx([0, 0, 0], abs=0.01)


def test_a_robot_that_was_held_in_a_turn_learns_nothing_from_it() -> None:
    assert turned_off(rolls=0.95, held=1)[2] == pytest.approx(turned_off(rolls=0.95)[2], abs=0.3)


def test_a_robot_that_takes_over_a_part_elsewhere_has_not_jumped() -> None:
    odometry = Odometry()
    odometry.begin({"r": following()}, 0.0)
    odometry.take(RawPose("r", LOCALIZATION, Pose(), 1.0))
    odometry.set_parts({"r": following("/spare")}, 1.1)
    found = odometry.take(RawPose("r", LOCALIZATION, Pose(0.6, 2), 1.2))
    assert found
    assert found.jump is None


@pytest.mark.parametrize(
    ("frames", "strays", "named"),
    [
        ({"a": "map", "b": "/map"}, [], ""),
        ({"a": "map", "b": "odom"}, ["a", "b"], "a in 'map' and b in 'odom'"),
        ({"a": "map", "b": "odom", "c": "map"}, ["b"], "a and c in 'map' and b in 'odom'"),
        ({"a": "a/odom", "b": "b/odom"}, ["a", "b"], "a in 'a/odom' and b in 'b/odom'"),
    ],
)
def test_poses_in_other_frames_than_most_count_for_nothing(
    frames: dict[str, str], strays: list[str], named: str
) -> None:
    odometry, robot = Odometry(), Robot(odom_frame="world")
    odometry.begin(dict.fromkeys(frames, following()), 0.0)
    robot.play("".join(f"{name} $ repeat forward\n" for name in frames), anyway=True)
    for name, frame in frames.items():
        odometry.take(RawPose(name, LOCALIZATION, Pose(0.1), 1.0, frame))
        robot.player.measure([RawPose(name, LOCALIZATION, Pose(), robot.stage.now, frame)], robot.stage.now)
    assert [name for name in frames if odometry.correction(name, Twist(0.1), 1.0) == STILL] == strays
    for name in frames:
        odometry.tell(name, Twist(0.1), 1.0)
    found = {name: odometry.take(RawPose(name, LOCALIZATION, Pose(0.1), 1.1, frame)) for name, frame in frames.items()}
    assert [name for name, each in found.items() if each and not each.follows] == strays
    assert [name for name, place in odometry.places(1.0).items() if place.pose is None] == strays
    robot.run(1)
    assert [each for each in robot.lines if "different frames" in each] == [
        f"poses in the world have different frames: {named}; no check and no correction uses those of "
        f"{' and '.join(strays)}: publish all in one frame"
        for _ in strays[:1]
    ]


LATE = [
    "poses of r come 0.5 s after they were measured: those older than 0.2 s correct no path and keep nobody apart; "
    "check the network, or the clock that stamps them",
    "poses of r come in time again",
]
WRONG = (
    "the clock that stamps poses of r is {} this machine's, so nobody knows how old they are: they count from "
    "when they come; synchronize the clocks, such as with chrony"
)


@pytest.mark.parametrize(
    ("ages", "how", "lines"),
    [
        ([0.08, 0.5, 0.5, 0.08], {"follow": True}, LATE),
        ([0.5, 0.5], {}, []),  # nothing depends on them
        ([5.02] * 3, {}, [WRONG.format("5.0 s behind")]),
        ([-59.92] * 3, {"follow": True}, [WRONG.format("59.9 s ahead of")]),
        ([60.08] * 3, {"follow": True}, [WRONG.format("60.1 s behind")]),
        ([0.06] * 3, {"follow": True}, []),
        ([-59.92] * 3, {"follow": True, "use_sim_time": True}, []),  # it is the clock of a simulation
    ],
)
def test_stamps_that_are_late_or_of_another_clock_are_named_once(
    ages: list[float], how: dict[str, Any], lines: list[str]
) -> None:
    robot = Robot(LOCALIZATION, Pose(), "world")
    robot.pose(Pose())  # which may have been measured long ago
    robot.play("beat 60\nr $ repeat forward\n", anyway=True, **how)
    for age in ages:
        robot.drive(1, age)
    assert [line for line in robot.lines if "poses of r" in line] == lines


@pytest.mark.parametrize(
    ("others", "line"),
    [
        (
            lambda y: 1.5 - y,
            "beat 2: a and b seem to be swapped, their poses jumped by 1.50 m: check what tells them apart",
        ),
        (
            lambda y: y + 3,
            "beat 2: the poses of a and b jumped by up to 3.00 m: "
            "unless somebody moved them, check the node that publishes them",
        ),
    ],
)
def test_two_swapped_robots_are_reported_in_one_line(others: Callable[[float], float], line: str) -> None:
    """Not if each jumps somewhere else."""
    robot = Robot(frame=Pose(), odom_frame="world")
    robot.play("beat 60\na b $ repeat forward\n", anyway=True)
    for step in range(40):
        at, place = robot.stage.now, (lambda y: y) if step < 22 else others
        poses = {"a": Pose(step / 10, place(0.0)), "b": Pose(step / 10, place(1.5))}
        robot.player.measure([RawPose(name, LOCALIZATION, pose, at) for name, pose in poses.items()], at)
        robot.run(0.05)
    told = [message["line"] for message in robot.stage.told if message["type"] == "fault"]
    assert [each for each in told if "jump" in each] == [line]


def test_a_robot_that_is_carried_away_or_lost_during_a_pause_is_named() -> None:
    robot = Robot(frame=Pose())
    robot.play("beat 60\nr $ repeat forward\n")
    robot.drive(0.5)
    robot.stage.ask("pause")
    for step in range(20):
        robot.pose(Pose(1, step / 40))
        robot.run(0.05)
    robot.stage.sink.deaf = {"r": "nobody listens on /r/cmd_vel"}
    robot.run(1.2)
    faults = [message["fault"] for message in robot.stage.told if message["type"] == "fault"]
    assert (faults, robot.stage.states[-1]) == (["off_path", "gone", "silent"], "paused")


@pytest.mark.parametrize(("end", "in_reach"), [("stop", False), ("pause", False), ("stop", True)])
def test_a_robot_that_is_stopped_out_of_reach_is_named_at_once(end: str, in_reach: bool) -> None:
    robot = Robot(frame=Pose())
    on_faults(robot, "tell", 1.2)
    if in_reach:
        robot.pose(Pose(4))
        robot.run(0.3)
    robot.stage.ask(end)
    told = [message for message in robot.stage.told if message["type"] == "unreached"]
    line = "r may still be moving: it is out of reach, so look at it"
    unreached = {"type": "unreached", "generation": 1, "robots": ["r"], "message": line}
    assert told == ([] if in_reach else [unreached])


def test_a_robot_that_stands_because_of_a_fault_stands_until_it_is_unmuted() -> None:
    robot = Robot(frame=Pose())
    on_faults(robot, "stand", 3.0)
    assert robot.stage.transports[-1]["muted"] == ["r"]
    robot.pose(Pose(4))
    robot.run(0.3)
    assert robot.lines[-1] == "beat 5: poses of r come again, after 3.0 s; it stands until you unmute it"
    assert robot.stage.sink.sent[-1][2] == STILL
    robot.stage.ask("silence", muted=[], soloed=[])
    assert robot.stage.sink.sent[-1][2] == Twist(2)


def test_a_hundred_robots_that_fail_at_once_share_a_line() -> None:
    robot, names = Robot(frame=Pose()), [f"r{number}" for number in range(120)]
    robot.play(f"beat 60\n{' '.join(names)} $ repeat forward\n")
    for _ in range(20):
        at = robot.stage.now
        robot.player.measure([RawPose(name, ODOMETRY, Pose(2 * (at - 1000)), at) for name in names], at)
        robot.run(0.05)
    robot.run(2.0)
    faults = [message for message in robot.stage.told if message["type"] == "fault"]
    assert sorted(each["robot"] for each in faults) == sorted(names)
    lines = [each["line"] for each in faults if each["line"]]
    assert len(lines) == 2
    assert all("no poses of r" in line and "more have come" in line for line in lines)


def test_the_states_of_real_robots_are_reported_every_second() -> None:
    robot = Robot(frame=Pose())
    robot.stage.sink.noted = Noticed(batteries={"r": 0.4})
    on_faults(robot, "tell", 0.5)
    vitals = [message["robots"]["r"] for message in robot.stage.told if message["type"] == "vitals"]
    assert len(vitals) == 2
    assert vitals[-1]["posed"] == pytest.approx(0.95, abs=0.1)
    assert (vitals[-1]["odom"], vitals[-1]["battery"]) == (True, 0.4)


@pytest.mark.parametrize("use_sim_time", [True, False])
def test_robots_that_stand_because_the_simulation_is_paused_are_not_blamed(use_sim_time: bool) -> None:
    robot = Robot(frame=Pose())
    robot.play("beat 60\nr $ repeat forward\n", use_sim_time=use_sim_time)
    robot.drive(1)
    noted = robot.stage.sink.noted
    robot.stage.sink.noted = replace(noted, frozen=True)
    for _ in range(40):
        robot.pose(Pose(2))
        robot.run(0.05)
    robot.run(2)
    robot.stage.sink.noted = noted
    for _ in range(10):
        robot.pose(Pose(2))
        robot.run(0.05)
    pauses = [line for line in robot.lines if "simulation" in line]
    assert [line.partition(",")[0] for line in pauses] == ["the simulation is paused", "the simulation runs again"]
    blamed = [line for line in robot.lines if "told to move" in line or "no pose of" in line]
    assert (blamed == []) == use_sim_time


def test_people_get_a_line_when_batteries_fall_below_20_and_10_percent() -> None:
    robot = Robot()

    def fall(seconds: float, **levels: float) -> list[str]:
        before = len(robot.lines)
        robot.stage.sink.noted = Noticed(batteries=levels)
        robot.run(seconds)
        return robot.lines[before:]

    robot.play("beat 60\na b $ repeat forward\n")
    assert fall(3, a=0.42, b=0.21) == []
    assert fall(3, a=0.42, b=0.194) == ["the battery of b is at 19%: charge it soon"]
    assert fall(3, a=0.42, b=0.15) == []
    assert fall(3, a=0.09, b=0.05) == ["the batteries of a and b are at 9% or less: charge them soon"]
    assert fall(3, a=0.09, b=0.0) == []
    robot.play("beat 60\na b $ repeat forward\n")
    assert fall(3, a=0.09, b=0.3) == ["the battery of a is at 9%: charge it soon"]


def test_positions_of_joints_are_reported_while_robots_play_and_for_a_moment_after() -> None:
    """Joints that are not in the robot's body belong to others."""
    stage = Stage()
    stage.sink.real = True
    stage.load("r is puppet\nbeat 60\nr $ head left")

    def measured(at: float) -> list[Any]:
        stage.told.clear()
        stage.player.measure_joints(RawJoints("r", {"head_yaw": 0.25, "wheel": 9.0}, at), stage.now)
        stage.player.measure_joints(RawJoints("other", {"head_yaw": 0.25}, at), stage.now)
        return [message for message in stage.told if message["type"] == "joints"]

    stage.run(0.5)
    (found,) = measured(stage.now - 0.1)
    assert (found["robot"], found["positions"]) == ("r", {"head_yaw": 0.25})
    assert (found["beat"], found["performed"]) == (pytest.approx(0.4), pytest.approx(0.4))
    stage.run(1.0)
    assert measured(stage.now)
    stage.run(MEASURED_AT_REST)
    assert not measured(stage.now)
