"""Commands of the ROS sink for controllers of joints, and their times. The test provides topics, measurements, and the
clock."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any, Literal
from unittest.mock import Mock

import pytest

from improv_core.outputs.ros.joints import controller as ros_controller
from improv_core.outputs.ros.joints import controllers as ros_controllers
from improv_core.outputs.ros.joints.controller import PERIOD
from improv_core.outputs.ros.joints.controllers import ANSWER_LIMIT, PATIENCE, STRING_ARRAY, RosControllers
from improv_core.outputs.ros.joints.trajectories import Course
from improv_core.safety.pending_zeros import LAST_ZEROS
from improv_core.score.algebra import hold
from improv_core.score.body import Body, BodyPart, Controller, Drive, Home, Joint
from improv_core.score.by_part import by_part
from improv_core.score.joints import JointMotion
from improv_core.score.motion import Pose
from improv_core.score.movement import Velocity
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part

HEAD = Controller("head", ("pitch", "yaw"))
VELOCITY = replace(HEAD, interface="velocity")
TOPIC, COMMANDS = "/ada/head_controller/joint_trajectory", "/ada/head_controller/commands"
SPEED = 2.0
"""The joints' highest speed in rad/s. They move to their starts at a fifth of it."""


class Topic:
    def __init__(self, name: str, message: str, node: object, robot: Robot, now: object, at_once: bool) -> None:
        self.name, self._robot = name, robot

    def missing(self, moves: bool) -> None:
        """Every message is received."""

    def ask(self, course: Course, clock: object, frame: bytes) -> None:
        self._robot.asked.append(motions(course))

    def publish(self, course: Course, clock: object, frame: bytes) -> None:
        self._robot.sent.append((self.name, motions(course)))
        self._robot.happened.append("sent")


@pytest.fixture(autouse=True)
def courses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Send courses instead of messages; tests/outputs/test_trajectories.py tests the messages."""
    monkeypatch.setattr(ros_controllers, "RosTopic", Topic)
    monkeypatch.setitem(sys.modules, "rcl_interfaces.srv", Mock())
    monkeypatch.setattr(ros_controller, "message_of", lambda channel, course, *more: course)


def motions(course: Course) -> list[tuple[float, float]]:
    return [(round(position, 6), velocity) for position, velocity in course.motions]


def part(*controllers: Controller, home: Home = "wait") -> Part:
    """The part of a robot that moves its head, left and up, by the joints yaw and pitch."""
    head = BodyPart("head", [Drive("yaw", "yaw", 1.0), Drive("z", "pitch", 1.0)])
    joints = [Joint(name, max_velocity=SPEED) for name in ("yaw", "pitch")]
    profile = replace(TURTLESIM, body=Body([head], (), joints, controllers, "joint_states", home))
    scene = by_part(hold(Velocity(0, 0, 1, 1), 1), "head")
    return Part("ada", (scene,), profile, Pose(), "/ada/cmd_vel", namespace="/ada")


class Robot:
    """A robot whose controllers begin to perform a part, its joint positions, and the lines and messages about it."""

    def __init__(self, performed: Part, *, lists: Sequence[str] | None = (), **joints: float) -> None:
        """Its controllers answer that their parameter `joints` `lists` these, is missing, or (None) not yet."""
        self.now, self.joints, self.lists = 100.0, joints, lists
        self.sent: list[tuple[str, list[tuple[float, float]]]] = []
        self.asked: list[list[tuple[float, float]]] = []
        self.said: list[str] = []
        self._program: dict[str, tuple[float, float, float]] = {}
        self.happened: list[Literal["said", "sent"]] = []
        self.pending_zeros = Mock()
        node: Any = SimpleNamespace(get_clock=lambda: None, create_client=lambda kind, service: self)
        advertise: Any = lambda channel: self  # noqa: E731
        self.controllers = RosControllers(
            node, advertise, self._measured, self.pending_zeros, self._say, lambda: self.now
        )
        self.controllers.take({"ada": performed}, restart=True, tempo=Fraction(60))

    # A client, its call, and the response.
    srv_type = Mock()

    def service_is_ready(self) -> bool:
        return True

    def call_async(self, request: object) -> Robot:
        return self

    def done(self) -> bool:
        return self.lists is not None

    def exception(self) -> None:
        """The call succeeds."""

    def result(self) -> SimpleNamespace:
        value = SimpleNamespace(type=STRING_ARRAY if self.lists else 0, string_array_value=self.lists)
        return SimpleNamespace(values=[value])

    def send(self, at: float, until: float = math.inf, **velocities: float) -> None:
        """Send velocities that last `until` a time. The program began at the joints' starts."""
        for joint, velocity in velocities.items():
            begin, moved, since = self._program.get(joint, (0.0, 0.0, at))
            self._program[joint] = begin + moved * (at - since), velocity, at
        told = {joint: JointMotion(*self._program[joint][:2]) for joint in velocities}
        self.controllers.send("ada", told, at, until=until)

    def home_joints(self, seconds: float) -> None:
        for _ in range(round(seconds / PERIOD)):
            self.controllers.waits()
            self.controllers.home_joints(["ada"])
            self.now += PERIOD

    def _say(self, line: str) -> None:
        self.said.append(line)
        self.happened.append("said")

    def _measured(self, robot: str) -> dict[str, tuple[float, float]]:
        return {joint: (position, self.now) for joint, position in self.joints.items()}


def test_joints_begin_at_their_measured_positions_and_arrive_where_the_program_has_them() -> None:
    robot = Robot(part(HEAD), pitch=-0.02, yaw=0.01)
    robot.send(0.0, yaw=1.0, pitch=-1.0, until=0.1)
    robot.send(0.1, yaw=0.0, pitch=0.0)
    assert robot.sent == [(TOPIC, [(-0.02, -0.5), (0.01, 0.5)]), (TOPIC, [(-0.1, 0), (0.1, 0)])]
    assert robot.said == []
    assert robot.pending_zeros.mock_calls == [], "trajectories end at rest"


def test_a_stop_brakes_joints_before_they_are_due_to_rest() -> None:
    """They have just begun to move, and their positions lag by the time over which they are smoothed."""
    robot = Robot(part(HEAD), pitch=0.0, yaw=0.0)
    robot.send(0.0, yaw=1.0, until=0.5)
    robot.send(0.1, yaw=0.0, until=0.1)
    assert robot.sent[-1] == (TOPIC, [(0, 0), (0.1, 0)])
    assert robot.said == []


@pytest.mark.parametrize("controller", [HEAD, replace(HEAD, joints=("yaw", "jaw", "pitch"))])
def test_joints_that_only_the_controller_lists_are_held_where_they_stand(controller: Controller) -> None:
    """It has a jaw besides, and its own order. A trajectory controller refuses a trajectory that lacks a joint."""
    robot = Robot(part(controller), lists=("jaw", "yaw", "pitch"), pitch=0.0, yaw=0.0, jaw=0.4)
    assert not robot.controllers.waits()
    robot.send(0.0, yaw=1.0)
    robot.joints |= {"yaw": 1.0, "jaw": 0.45}
    robot.send(1.0, yaw=0.0)
    assert robot.sent == [(TOPIC, [(0.4, 0), (0, 1), (0, 0)]), (TOPIC, [(0.4, 0), (1, 0), (0, 0)])]


def test_held_joints_stay_while_the_others_move_to_their_starts() -> None:
    robot = Robot(part(HEAD, home="move"), lists=("pitch", "yaw", "jaw"), yaw=-0.3, pitch=0.0, jaw=0.4)
    robot.home_joints(PERIOD)
    assert robot.sent == [(TOPIC, [(0, 0), (-0.3, 0.4), (0.4, 0)])]


def test_nothing_moves_while_the_position_of_a_held_joint_is_unknown() -> None:
    robot = Robot(part(HEAD), lists=("pitch", "yaw", "jaw"), pitch=0.0, yaw=0.0)
    assert robot.controllers.waits()
    robot.now += PATIENCE
    robot.controllers.waits()
    assert robot.said[0].startswith("nothing moves: it isn't known where jaw of ada is")


def test_a_velocity_controller_gets_a_zero_for_held_joints() -> None:
    robot = Robot(part(VELOCITY), lists=("jaw", "pitch", "yaw"))
    robot.send(0.0, yaw=1.0)
    assert robot.sent == [(COMMANDS, [(0, 0), (0, 0), (0, 1)])]


def test_nothing_is_sent_while_a_controller_may_still_list_its_joints() -> None:
    """A node that never answers holds it up for a short time only."""
    robot = Robot(part(HEAD), lists=None, pitch=0.0, yaw=0.0)
    robot.send(0.0, yaw=1.0)
    robot.controllers.ask(["ada"])
    assert robot.controllers.waits()
    assert (robot.asked, robot.sent) == ([], [])
    robot.now += ANSWER_LIMIT
    assert not robot.controllers.waits()
    robot.send(0.0, yaw=1.0)
    assert robot.sent == [(TOPIC, [(0, 0), (0, 1)])]


def test_joints_that_a_controller_lists_late_are_sent_from_then_on() -> None:
    """Its listeners have confirmed a command for the joints of `improv.toml`, which have never moved."""
    robot = Robot(part(HEAD), lists=None, pitch=0.0, yaw=0.0, jaw=0.0)
    robot.now += ANSWER_LIMIT
    assert not robot.controllers.waits()
    robot.controllers.ask(["ada"])
    robot.lists = ("jaw", "yaw", "pitch")
    assert not robot.controllers.waits()
    robot.send(0.0, yaw=1.0)
    assert robot.sent == [(TOPIC, [(0, 0), (0, 1), (0, 0)])]


def test_a_joint_that_the_controller_lacks_is_named_and_not_sent() -> None:
    robot = Robot(part(HEAD), lists=("yaw",), pitch=0.0, yaw=0.0)
    robot.send(0.0, yaw=1.0, pitch=1.0)
    assert robot.sent == [(TOPIC, [(0, 1)])]
    assert robot.controllers.warning("ada", lambda topic, guarded: []) == (
        f"the controller on {TOPIC} has no pitch, only yaw: correct its `joints` in improv.toml"
    )


def test_the_joints_of_a_node_that_is_no_controller_of_them_do_not_count() -> None:
    robot = Robot(part(HEAD), lists=("wheel",), pitch=0.0, yaw=0.0)
    robot.send(0.0, yaw=1.0)
    assert robot.sent == [(TOPIC, [(0, 0), (0, 1)])]


def test_a_joint_that_is_held_back_does_not_jump_later() -> None:
    """It stays put while it should have turned by several radians, as in a protective stop."""
    robot = Robot(part(HEAD), pitch=-0.02, yaw=0.01)
    for number in range(60):
        robot.send(0.1 * number, yaw=1.0)
        robot.now += 0.1
    assert max(motions[1][0] for _, motions in robot.sent) < 1.0
    assert robot.said == []
    robot.send(6.0, yaw=0.0)
    robot.send(6.05, yaw=0.0)
    assert robot.sent[-2:] == [(TOPIC, [(-0.02, 0), (0.01, 0)])] * 2
    assert robot.said == ["joints of ada rest off the program, yaw by -343°: play from beat 1 to bring them back"]


def test_a_controller_whose_joints_do_not_follow_is_named() -> None:
    """It has refused everything, or the stage hears no positions anymore."""
    robot = Robot(part(HEAD), pitch=0.0, yaw=0.0)
    for tick in range(25):
        robot.send(tick * PERIOD, yaw=1.0, pitch=0.2)
        assert (robot.controllers.unfollowed() == {}) is (tick <= 22)
        robot.now += PERIOD
    assert robot.controllers.unfollowed()["ada"].why == (
        "/ada/head_controller moves nothing: its log says if it is inactive or refuses what it gets"
    )
    robot.joints.clear()
    assert robot.controllers.unfollowed()["ada"].why.startswith("no position of pitch comes on /ada/joint_states")


def test_repeats_that_are_left_out_pass_no_time_twice() -> None:
    """Two body parts ask for repeats at different times, and one of them too often."""
    robot = Robot(part(HEAD), pitch=0.0, yaw=0.0)
    for tick in range(22):
        for share, told in ((0, {"yaw": 1.0}), (1, {"pitch": 0.2}), (2, {"yaw": 1.0})):
            robot.now = 100.0 + (tick + share / 4) * PERIOD
            robot.send(robot.now, **told)
    assert robot.controllers.unfollowed() == {}


def test_a_controller_that_leaves_improv_toml_is_stopped() -> None:
    """A save takes over while joints move."""
    robot = Robot(part(HEAD), pitch=0.0, yaw=0.0)
    robot.send(0.0, yaw=1.0)
    robot.now += 0.2
    robot.joints["yaw"] = 0.2
    other = Controller("other", HEAD.joints, interface="position")
    robot.controllers.take({"ada": part(other)}, restart=False, tempo=Fraction(60))
    assert robot.sent[1:] == [(TOPIC, [(0, 0), (0.2, 0)])] * LAST_ZEROS
    robot.send(0.2, yaw=1.0)
    assert robot.sent[-1] == ("/ada/other_controller/commands", [(0, 0), (0.2, 1)])


def test_a_velocity_controller_that_leaves_needs_zeros() -> None:
    robot = Robot(part(VELOCITY))
    robot.send(0.0, yaw=1.0)
    robot.controllers.take({"ada": part(HEAD)}, restart=False, tempo=Fraction(60))
    assert robot.sent[1:] == [(COMMANDS, [(0, 0), (0, 0)])] * LAST_ZEROS
    assert [name for name, *_ in robot.pending_zeros.mock_calls] == ["note_velocity", "note_zero"]


def test_a_command_ends_the_way_to_the_starts() -> None:
    robot = Robot(part(HEAD, home="move"), yaw=-1.5, pitch=0.0)
    robot.home_joints(PERIOD)
    robot.send(0.0, yaw=1.0)
    robot.now += 1.0
    robot.send(1.0, yaw=2.0)
    assert [motions[1][1] for _, motions in robot.sent] == [0.4, 0, 1.5, 2]


def test_velocity_controllers_need_zeros_but_no_measured_positions() -> None:
    robot = Robot(part(VELOCITY))
    robot.send(0.0, yaw=1.0, pitch=-0.5)
    robot.send(1.0, pitch=0.0)
    assert [name for name, *_ in robot.pending_zeros.mock_calls] == ["note_velocity", "note_velocity"], (
        "one of them still turns"
    )
    robot.send(1.5, yaw=0.0)
    assert [[velocity for _, velocity in motions] for _, motions in robot.sent] == [[-0.5, 1], [0, 1], [0, 0]]
    assert [name for name, *_ in robot.pending_zeros.mock_calls] == ["note_velocity", "note_velocity", "note_zero"]
    moved = robot.pending_zeros.note_velocity.call_args.args[0]
    stood = robot.pending_zeros.note_zero.call_args.args[1]
    assert moved.name == stood.name == COMMANDS


def test_only_finite_numbers_are_sent() -> None:
    robot = Robot(part(HEAD), yaw=0.0, pitch=0.0)
    with pytest.raises(ValueError, match="ada was given a joint's speed that is not a finite number"):
        robot.send(0.0, yaw=float("nan"))
    assert robot.sent == []


def test_other_nodes_that_move_the_same_joints_are_named() -> None:
    robot = Robot(part(HEAD))
    assert robot.controllers.warning("ada", lambda topic, guarded: [] if guarded else ["/moveit"]) == (
        f"other nodes also publish to {TOPIC}: /moveit; joints obey all of them: stop the others"
    )


def test_nothing_moves_while_joint_positions_are_unknown() -> None:
    """The first positions may take a while to arrive."""
    robot = Robot(part(HEAD))
    assert robot.controllers.waits()
    assert robot.said == []
    robot.now += PATIENCE
    assert robot.controllers.waits()
    (line,) = robot.said
    assert line.startswith(
        "nothing moves: it isn't known where pitch of ada is: start the node that publishes its position on"
    )
    robot.send(0.0, yaw=1.0)
    assert robot.sent == []


def test_joints_get_no_commands_until_a_person_has_moved_them_to_their_starts() -> None:
    """A person has to move them, and that person's commands to the controller must count."""
    robot = Robot(part(HEAD), yaw=0.5, pitch=0.0)
    assert robot.controllers.waits()
    robot.controllers.ask(["ada"])
    robot.home_joints(1.0)
    assert (robot.asked, robot.sent) == ([], [])
    robot.joints["yaw"] = 0.0
    assert not robot.controllers.waits()
    robot.controllers.ask(["ada"])
    assert robot.asked == [[(0, 0), (0, 0)]]


def test_joints_are_brought_to_their_starts_slowly() -> None:
    """A controller obeys: yaw turns by 0.3 rad at 0.4 rad/s."""
    robot = Robot(part(HEAD, home="move"), yaw=-0.3, pitch=0.0)
    while robot.controllers.waits():
        robot.home_joints(PERIOD)
        robot.joints["yaw"] = min(robot.joints["yaw"] + 0.4 * PERIOD, 0.0)
    assert robot.sent[0] == (TOPIC, [(0, 0), (-0.3, 0.4)])
    assert robot.sent[-1] == (TOPIC, [(0, 0), (0, 0)])
    assert robot.now == pytest.approx(100.75, abs=2 * PERIOD)
    assert robot.said == ["joints move to their starts first: yaw of ada by +17°"]


def test_joints_are_named_before_they_move() -> None:
    """The position of pitch arrives 2.9 s later. A line about the missing position would come only after 5 s."""
    yaw, pitch = (replace(HEAD, name=name, joints=(name,)) for name in ("yaw", "pitch"))
    robot = Robot(part(yaw, pitch, home="move"), yaw=-1.5)
    robot.home_joints(PERIOD)
    assert robot.happened == ["said", "sent"]
    assert [topic for topic, _ in robot.sent] == ["/ada/yaw_controller/joint_trajectory"]
    assert robot.said == ["joints move to their starts first: yaw of ada by +86°"]
    for _ in range(58):
        robot.joints["yaw"] += 0.4 * PERIOD
        robot.home_joints(PERIOD)
    robot.joints["pitch"] = 0.5
    robot.home_joints(PERIOD)
    assert [topic for topic, _ in robot.sent].count("/ada/pitch_controller/joint_trajectory") == 1
    assert robot.said[1:] == ["joints move to their starts first: pitch of ada by -29°"]


def test_a_stop_holds_joints_on_their_way_to_their_starts() -> None:
    robot = Robot(part(HEAD, home="move"), yaw=-1.5, pitch=0.0)
    robot.home_joints(PERIOD)
    robot.controllers.halt("ada")
    assert [velocity for _, velocity in robot.sent[-1][1]] == [0, 0]
    assert robot.controllers.waits()


def test_joints_that_were_halted_on_their_way_are_named_again_when_they_continue() -> None:
    """The deadman button was released for a moment."""
    robot = Robot(part(HEAD, home="move"), yaw=-1.5, pitch=0.0)
    robot.home_joints(PERIOD)
    robot.controllers.home_joints([])
    robot.now += 1.0
    robot.home_joints(PERIOD)
    assert robot.said == ["joints move to their starts first: yaw of ada by +86°"] * 2


def test_joints_that_are_held_back_on_their_way_stay_where_they_are() -> None:
    """They must not jump to their starts when released: a person has to move them there."""
    robot = Robot(part(HEAD, home="move"), yaw=-1.5, pitch=0.0)
    robot.home_joints(3.0)
    assert robot.sent[-1] == (TOPIC, [(0, 0), (-1.5, 0)])
    count = len(robot.sent)
    robot.home_joints(5.0)
    assert len(robot.sent) == count
    assert robot.said[-1] == "nothing moves until all joints are at their starts: turn yaw of ada by +86°"
