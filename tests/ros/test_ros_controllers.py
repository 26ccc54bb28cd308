"""The ROS sink alone, and listeners to commands for joints. tests/outputs tests the effects, with a clock."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ros.conftest import Listen, Publish, Sink

pytestmark = pytest.mark.slow("processes of ROS find each other")

TRAJECTORIES, NUMBERS = "trajectory_msgs/JointTrajectory", "std_msgs/Float64MultiArray"
TOPIC, COMMANDS = "/ada/head_controller/joint_trajectory", "/ada/head_controller/commands"
HEAD = {"name": "head", "joints": ["pitch", "yaw"]}
VELOCITY = {**HEAD, "interface": "velocity"}


def states(publish: Publish, **positions: float) -> None:
    """Publish the positions of joints."""
    fields = {"name": [*positions], "position": [*positions.values()]}
    publish("/ada/joint_states", "sensor_msgs/JointState")(fields)


def points(message: dict[str, Any]) -> list[list[Any]]:
    """Return the points of a trajectory, rounded."""
    return [
        [seconds, [round(each, 6) for each in positions], [round(each, 6) for each in velocities]]
        for seconds, positions, velocities in message["points"]
    ]


def moves(message: dict[str, Any]) -> bool:
    return len(message["points"]) > 1


def test_trajectories_begin_where_joints_are_measured_and_end_at_rest(
    sink: Sink, listen: Listen, publish: Publish
) -> None:
    """The joints are a little off their starts."""
    head = listen(TOPIC, type=TRAJECTORIES)
    states(publish, yaw=0.01, pitch=-0.02, wheel=3.0)
    sink("prepare_body", [HEAD])
    assert sink("joints") == ["ada", {"yaw": 0.01, "pitch": -0.02, "wheel": 3.0}]
    sink("wait")
    sink("send_joints", 0.0, yaw=1.0, pitch=0.0)
    moving = head.wait(moves)
    assert moving["joints"] == ["pitch", "yaw"]
    assert points(moving) == [
        [0, [-0.02, 0.01], [0, 1]],
        [0.2, [-0.02, 0.21], [0, 1]],
        [0.3, [-0.02, 0.26], [0, 0]],
    ]
    assert all(points(message) == [[0, [-0.02, 0.01], [0, 0]]] for message in head.heard[:-1]), "it was asked"


def test_a_controller_without_a_fitting_listener_is_named(sink: Sink, publish: Publish, listen: Listen) -> None:
    """The base has nothing to do, so it isn't missing."""
    states(publish, yaw=0.0, pitch=0.0)
    sink("prepare_body", [HEAD])
    line = sink("find", "missing", "ada", "nothing is listening")
    assert line.startswith(f"nothing is listening on {TOPIC} (ROS 2, domain ")
    listen(TOPIC, type=NUMBERS)
    line = sink("find", "missing", "ada", "expects")
    assert f"the listener on {TOPIC} expects std_msgs/msg/Float64MultiArray, not trajectory_msgs/msg/JointTraj" in line


def test_zeros_of_velocities_stay_pending_until_they_are_heard(sink: Sink, listen: Listen) -> None:
    """No node publishes the positions of the joints, and none has to."""
    listener = listen(COMMANDS, type=NUMBERS)
    sink("prepare_body", [VELOCITY], states=None)
    sink("wait")
    sink("send_joints", 0.0, yaw=1.0, pitch=-0.5)
    listener.wait(lambda message: message["numbers"] == [-0.5, 1])
    sink("send_joints", 1.0, pitch=0.0)
    listener.wait(lambda message: message["numbers"] == [0, 1])
    sink("send_joints", 1.5, yaw=0.0)
    sink("until_no_zero_pends")
    listener.wait(lambda message: message["numbers"] == [0, 0])


def test_joints_on_their_way_to_their_starts_are_stopped(sink: Sink, publish: Publish, listen: Listen) -> None:
    """No measurement shows that they move, so beat 0 still waits."""
    listener = listen(TOPIC, type=TRAJECTORIES)
    states(publish, yaw=0.1, pitch=0.0)
    sink("prepare_body", [HEAD], home="move", max_velocity=2.0)
    sink("bring_home")
    moving = listener.wait(moves)
    assert points(moving)[0] == [0, [0, 0.1], [0, -0.4]]
    assert points(listener.wait(lambda message: not moves(message)))[0][2] == [0, 0], "it was stopped"
    assert sink("resetting")
