"""The ROS sink alone, and a listener to commands for joints. tests/outputs tests the effects, with a clock."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ros.conftest import Listen, Publish, Sink

pytestmark = pytest.mark.slow("processes of ROS find each other")


def test_joints_on_their_way_to_their_starts_are_stopped(sink: Sink, publish: Publish, listen: Listen) -> None:
    """No measurement shows that they move, so beat 0 still waits."""
    listener = listen("/ada/head_controller/joint_trajectory", type="trajectory_msgs/JointTrajectory")
    publish("/ada/joint_states", "sensor_msgs/JointState")({"name": ["yaw", "pitch"], "position": [0.1, 0.0]})
    sink("prepare_body", [{"name": "head", "joints": ["pitch", "yaw"]}], home="move", max_velocity=2.0)
    sink("bring_home")
    assert first_point(listener.wait(lambda message: len(message["points"]) > 1)) == [0, [0, 0.1], [0, -0.4]]
    assert first_point(listener.wait(lambda message: len(message["points"]) == 1))[2] == [0, 0], "it was stopped"
    assert sink("resetting")


def first_point(message: dict[str, Any]) -> list[Any]:
    """Return the first point of a trajectory, rounded."""
    seconds, *motion = message["points"][0]
    return [seconds, *([round(each, 6) for each in numbers] for numbers in motion)]
