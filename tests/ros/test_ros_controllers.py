"""The ROS sink alone, and who listens for what joints are told."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ros.conftest import Listen, Listener, Publish, Script, Sink
from tests.ros.test_controllers import CONTROLLER

pytestmark = pytest.mark.slow("processes of ROS find each other")

TRAJECTORIES, NUMBERS = "trajectory_msgs/JointTrajectory", "std_msgs/Float64MultiArray"
TOPIC, COMMANDS = "/ada/head_controller/joint_trajectory", "/ada/head_controller/commands"
HEAD = {"name": "head", "joints": ["pitch", "yaw"]}
VELOCITY = {**HEAD, "interface": "velocity"}


def states(publish: Publish, **positions: float) -> None:
    """Somebody says where joints are."""
    fields = {"name": [*positions], "position": [*positions.values()]}
    publish("/ada/joint_states", "sensor_msgs/JointState")(fields)


def points(message: dict[str, Any]) -> list[list[Any]]:
    """Rounded."""
    return [
        [seconds, [round(each, 6) for each in positions], [round(each, 6) for each in velocities]]
        for seconds, positions, velocities in message["points"]
    ]


def moves(message: dict[str, Any]) -> bool:
    return len(message["points"]) > 1


@pytest.fixture
def head(sink: Sink, listen: Listen, publish: Publish) -> Listener:
    """Its joints are a little off their starts."""
    listener = listen(TOPIC, type=TRAJECTORIES)
    states(publish, yaw=0.01, pitch=-0.02)
    sink("prepare_body", [HEAD])
    sink("wait")
    return listener


def test_trajectories_begin_where_joints_are_measured_and_end_at_rest(sink: Sink, head: Listener) -> None:
    sink("send_joints", 0.0, yaw=1.0, pitch=0.0)
    moving = head.wait(moves)
    assert moving["joints"] == ["pitch", "yaw"]
    assert points(moving) == [
        [0, [-0.02, 0.01], [0, 1]],
        [0.2, [-0.02, 0.21], [0, 1]],
        [0.3, [-0.02, 0.26], [0, 0]],
    ]
    assert all(points(message) == [[0, [-0.02, 0.01], [0, 0]]] for message in head.heard[:-1]), "it was asked"


def test_a_stop_holds_joints_where_they_are_by_then(sink: Sink, head: Listener) -> None:
    sink("send_joints", 0.0, yaw=1.0, pitch=-1.0)
    sink("send_joints", 0.25, yaw=0.0, pitch=0.0)
    head.wait(moves)
    assert points(head.wait(lambda message: not moves(message))) == [[0, [-0.27, 0.26], [0, 0]]]


def test_a_joint_that_is_held_back_does_not_jump_later(sink: Sink, head: Listener, publish: Publish) -> None:
    """It stays where it is while it should have turned by several radians, as in a protective stop."""
    for seconds in range(20):
        states(publish, yaw=0.01, pitch=-0.02)
        sink("send_joints", 3.0 * seconds, yaw=1.0 + seconds % 2)
    head.wait(lambda message: moves(message) and points(message)[0] == [0, [-0.02, 0.01], [0, 2]])
    assert sink("lines") == ["yaw of ada is held back: it continues from where it is, not as the program says"]


def test_a_controller_that_leaves_improv_toml_is_told_to_stand(sink: Sink, head: Listener, listen: Listen) -> None:
    """A save takes over while joints move."""
    numbers = listen("/ada/other_controller/commands", type=NUMBERS)
    sink("send_joints", 0.0, yaw=1.0)
    head.wait(moves)
    sink("prepare_body", [{**HEAD, "name": "other", "interface": "position"}], False)
    stands = points(head.wait(lambda message: not moves(message)))
    assert [velocities for _, _, velocities in stands] == [[0, 0]]
    sink("wait")
    sink("send_joints", 0.5, yaw=1.0)
    numbers.wait(lambda message: message["numbers"] == [-0.02, 0.01])


def test_nobody_who_listens_to_a_controller(sink: Sink, publish: Publish, listen: Listen) -> None:
    """The base has nothing to do, so it isn't missing."""
    states(publish, yaw=0.0, pitch=0.0)
    sink("prepare_body", [HEAD])
    line = sink("find", "missing", "ada", "nothing is listening")
    assert line.startswith(f"nothing is listening on {TOPIC} (ROS 2, domain ")
    listen(TOPIC, type=NUMBERS)
    line = sink("find", "missing", "ada", "expects")
    assert f"the listener on {TOPIC} expects std_msgs/msg/Float64MultiArray, not trajectory_msgs/msg/JointTraj" in line


def test_others_who_move_the_same_joints_are_named(sink: Sink, head: Listener, publish: Publish) -> None:
    publish(TOPIC, TRAJECTORIES, name="moveit")
    line = sink("find", "warnings", "ada", "other nodes")
    assert line == f"other nodes also publish to {TOPIC}: /moveit; joints obey all of them: stop the others"


def test_joints_that_are_elsewhere_are_sent_nothing(sink: Sink, publish: Publish, listen: Listen) -> None:
    """Somebody brings them to their starts; what that person tells the controller must count."""
    listener = listen(TOPIC, type=TRAJECTORIES)
    states(publish, yaw=0.5, pitch=0.0)
    sink("prepare_body", [HEAD])
    listener.wait_for_publishers(lambda count: count == 1)
    for _ in range(20):
        assert sink("resetting")
        sink("missing")
    listener.hear_all()
    assert listener.heard == []
    states(publish, yaw=0.0, pitch=0.0)
    sink("wait")
    listener.wait(lambda message: points(message) == [[0, [0, 0], [0, 0]]])


def test_velocities_are_owed_zeros_until_they_are_heard(sink: Sink, listen: Listen) -> None:
    """Nobody says where the joints are, and nobody needs to."""
    listener = listen(COMMANDS, type=NUMBERS)
    sink("prepare_body", [VELOCITY], states=None)
    sink("wait")
    sink("send_joints", 0.0, yaw=1.0, pitch=-0.5)
    listener.wait(lambda message: message["numbers"] == [-0.5, 1])
    sink("send_joints", 1.0, pitch=0.0)
    listener.wait(lambda message: message["numbers"] == [0, 1])
    sink("send_joints", 1.5, yaw=0.0)
    sink("until_paid")
    listener.wait(lambda message: message["numbers"] == [0, 0])


def test_what_is_no_number_is_never_sent(sink: Sink, head: Listener) -> None:
    with pytest.raises(AssertionError, match="ada was given a joint's speed that is not a finite number"):
        sink("send_joints", 0.0, yaw=float("nan"))


HOME = {"home": "move", "max_velocity": 2.0}


def test_joints_are_brought_to_their_starts_slowly(sink: Sink, publish: Publish, listen: Listen) -> None:
    """Nobody measures that they move, so beat 0 still waits."""
    listener = listen(TOPIC, type=TRAJECTORIES)
    states(publish, yaw=0.1, pitch=0.0)
    sink("prepare_body", [HEAD], **HOME)
    sink("bring_home_until_they_move")
    moving = listener.wait(moves)
    assert points(moving)[0] == [0, [0, 0.1], [0, -0.4]]
    assert points(listener.wait(lambda message: not moves(message)))[0][2] == [0, 0], "it was stopped"
    assert sink("resetting")


def test_joints_that_are_held_back_on_their_way_stay_where_they_are(
    sink: Sink, publish: Publish, listen: Listen
) -> None:
    """Once they are let go, they must not jump to their starts."""
    listener = listen(TOPIC, type=TRAJECTORIES)
    states(publish, yaw=-1.5, pitch=0.0)
    sink("prepare_body", [HEAD], **HOME)
    sink("bring_home_in_vain")
    listener.wait(moves)
    assert points(listener.wait(lambda message: not moves(message))) == [[0, [0, -1.5], [0, 0]]]
    assert sink("resetting"), "somebody has to bring them there"


def test_a_dance_begins_once_joints_are_at_their_starts(sink: Sink, publish: Publish, script: Script) -> None:
    """A controller obeys: its joint goes 0.3 rad at 0.4 rad/s."""
    script(CONTROLLER, "ada", *["--controller", "head", "trajectory", "yaw", "pitch", "--start", "yaw", "-0.3"])
    sink("prepare_body", [HEAD], **HOME)
    sink("bring_home")
    assert not sink("resetting")


def test_where_joints_are_is_passed_on(sink: Sink, publish: Publish) -> None:
    states(publish, yaw=0.5, wheel=3.0)
    sink("prepare_body", [HEAD])
    assert sink("joints") == ["ada", {"yaw": 0.5, "wheel": 3.0}]
