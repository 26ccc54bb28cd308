"""The ROS sink alone, and a listener to commands for joints. tests/outputs/test_ros_controllers.py has all other
commands, with a clock."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ros.conftest import Listen, Publish, Sink

pytestmark = pytest.mark.slow("processes of ROS find each other")


def cruises(message: dict[str, Any]) -> bool:
    """Return whether a trajectory moves its only joint at its speed: a fifth of its highest one, in rad/s."""
    return any(abs(velocity + 0.4) < 1e-6 for _, _, (velocity,) in message["points"])


def test_a_zero_to_a_robot_stops_joints_on_their_way_to_their_starts(
    sink: Sink, publish: Publish, listen: Listen
) -> None:
    """No measurement shows that they move, so beat 0 still waits."""
    listener = listen("/ada/head_controller/joint_trajectory", type="trajectory_msgs/JointTrajectory")
    publish("/ada/joint_states", "sensor_msgs/JointState")({"name": ["yaw"], "position": [0.1]})
    sink("prepare_body", {"name": "head", "joints": ["yaw"]}, max_velocity=2.0)
    sink("stop_on_the_way_home")
    listener.wait(cruises)
    listener.wait(lambda message: not cruises(message))
