"""Measured movements of robots, over ROS: poses of each type, from their topics to the page."""

from __future__ import annotations

import math
import subprocess
from typing import Any

import pytest

from improv_core.outputs.cdr import POSE_TEXTS
from tests.needs import lacking
from tests.ros.conftest import LIMIT, Publish, Sink

pytestmark = pytest.mark.slow("processes of ROS find each other")

CMD = {"anna": "/anna/cmd_vel"}


def fields(kind: str, x: float, heading: float) -> dict[str, float]:
    """Return a message with a heading; its stamp is from 1970."""
    pose = "pose" if kind == "geometry_msgs/PoseStamped" else "pose.pose"
    turn = {f"{pose}.orientation.z": math.sin(heading / 2), f"{pose}.orientation.w": math.cos(heading / 2)}
    return {f"{pose}.position.x": x, **turn}


@pytest.mark.parametrize("kind", POSE_TEXTS)
def test_poses_of_each_type_and_with_any_stamps_are_read(kind: Any, publish: Publish, sink: Sink) -> None:
    topic = f"/anna/{kind.rpartition('/')[2]}"
    publish(topic, kind)(fields(kind, 1.5, 2.0))
    sink("prepare", CMD, odom=topic)
    (robot, source, x, y, heading), ago = sink("pose")
    assert (robot, source, x, y, heading) == ("anna", kind, 1.5, 0, 2.0)
    assert 0 <= ago < LIMIT


def test_a_pose_that_came_before_anybody_listened_counts_if_it_is_latched(publish: Publish, sink: Sink) -> None:
    """AMCL sends a pose only after a robot has moved."""
    kind = "geometry_msgs/PoseWithCovarianceStamped"
    amcl = publish("/anna/amcl_pose", kind, latched=True)
    amcl(fields(kind, 1.5, 2.0), once=True)
    sink("prepare", CMD, odom="/anna/amcl_pose")
    assert sink("pose")[0] == ["anna", kind, 1.5, 0, 2.0]
    amcl(fields(kind, 1.6, 2.0), once=True)
    assert sink("pose")[0] == ["anna", kind, 1.6, 0, 2.0]


def transform(parent: str, child: str, x: float, second: int = 1) -> dict[str, Any]:
    place = {"header.frame_id": parent, "child_frame_id": child, "transform.translation.x": x}
    return {"type": "geometry_msgs/TransformStamped", "fields": {"header.stamp.sec": second, **place}}


def test_poses_come_from_tf_and_from_transforms_that_never_change(
    ros_python: str, publish: Publish, sink: Sink
) -> None:
    if subprocess.run([ros_python, "-c", "import tf2_msgs.msg"], capture_output=True).returncode:
        lacking("tf2_msgs is not installed: sh tests/ros/fetch.sh")
    fixed = publish("/anna/tf_static", "tf2_msgs/TFMessage", latched=True, name="description")
    fixed({"transforms": [transform("map", "odom", 4.0)]}, once=True)
    wheels = publish("/anna/tf", "tf2_msgs/TFMessage")
    sink("prepare", CMD, odom="/anna/tf", namespace="/anna")
    found, second = 0.0, 0
    while found != 5.5:  # until then, the other topic has yet to be found
        second += 1  # a pose with the stamp of one that has come is none
        wheels({"transforms": [transform("odom", "base_link", 1.5, second)]})
        robot, source, found, *_ = sink("pose")[0]
        assert (robot, source) == ("anna", "tf2_msgs/TFMessage")


def test_a_robot_that_moves_without_a_pose_is_named(publish: Publish, sink: Sink) -> None:
    what = "anna's real position is unknown"
    sink("prepare", CMD, odom="/anna/odom")
    sink("send", "anna", 1, 0, 0, 0)
    assert sink("find", "warnings", "anna", what) == f"nobody publishes on /anna/odom: {what}"
    poses = publish("/anna/odom", "nav_msgs/Odometry")
    poses(fields("nav_msgs/Odometry", 0, 0))
    sink("until_no_warnings")
    poses(None)  # from now on, that is a fault of the robot
    sink("prepare", CMD, odom="/anna/cmd_vel")
    sink("send", "anna", 1, 0, 0, 0)
    assert "/anna/cmd_vel carries geometry_msgs/Twist, not nav" in sink("find", "warnings", "anna", "carries")


def test_the_level_of_a_battery_is_read(publish: Publish, sink: Sink) -> None:
    sink("prepare", CMD, battery="/anna/battery")
    publish("/anna/battery", "sensor_msgs/BatteryState")({"percentage": 0.42})
    assert sink("battery", "anna") == pytest.approx(0.42)
