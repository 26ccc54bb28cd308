"""Poses in serialized messages that another library has written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.outputs.cdr import POSE_TEXTS, SECOND, joints_in, pose_in, stamp_in, transforms_in, twist_in
from improv_core.outputs.ros.sensors.polled import STATIC, Polled
from improv_core.outputs.ros.sensors.poses import PoseReader
from improv_core.score.motion import Pose
from tests.recordings import ROS

TYPES = ROS.types


def message(kind: str, pose: Pose, frames: Sequence[str] = ("odom", "base_link"), **turn: Any) -> bytes:
    """A message of one of the three types; `turn` replaces numbers of the quaternion."""

    def of(name: str, **fields: Any) -> Any:
        return TYPES[name.replace("/", "/msg/")](**fields)

    half = pose.heading / 2
    quaternion = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half), **turn}
    where = of(
        "geometry_msgs/Pose",
        position=of("geometry_msgs/Point", x=pose.x, y=pose.y, z=pose.z),
        orientation=of("geometry_msgs/Quaternion", **quaternion),
    )
    header = of("std_msgs/Header", stamp=of("builtin_interfaces/Time", sec=3, nanosec=5), frame_id=frames[0])
    zeros = of("geometry_msgs/Vector3", x=7.0, y=7.0, z=7.0)
    covariance = numpy.zeros(36)
    uncertain = of("geometry_msgs/PoseWithCovariance", pose=where, covariance=covariance)
    if kind == "geometry_msgs/PoseStamped":
        made = of(kind, header=header, pose=where)
    elif kind == "geometry_msgs/PoseWithCovarianceStamped":
        made = of(kind, header=header, pose=uncertain)
    else:
        twist = of("geometry_msgs/Twist", linear=zeros, angular=zeros)
        moving = of("geometry_msgs/TwistWithCovariance", twist=twist, covariance=covariance)
        made = of(kind, header=header, child_frame_id=frames[1], pose=uncertain, twist=moving)
    return bytes(ROS.serialize_cdr(made, kind.replace("/", "/msg/")))


def transforms(*links: tuple[str, str, Pose], at: int = 3) -> bytes:
    """A message with the poses of frames in their parents, at a time in seconds."""

    def of(name: str, **fields: Any) -> Any:
        return TYPES[f"geometry_msgs/msg/{name}"](**fields)

    made = []
    for parent, child, pose in links:
        stamp = TYPES["builtin_interfaces/msg/Time"](sec=at, nanosec=5)
        header = TYPES["std_msgs/msg/Header"](stamp=stamp, frame_id=parent)
        turn = of("Quaternion", x=0.0, y=0.0, z=math.sin(pose.heading / 2), w=math.cos(pose.heading / 2))
        place = of("Transform", translation=of("Vector3", x=pose.x, y=pose.y, z=pose.z), rotation=turn)
        made.append(of("TransformStamped", header=header, child_frame_id=child, transform=place))
    return bytes(ROS.serialize_cdr(TYPES[TF](transforms=made), TF))


TF = "tf2_msgs/msg/TFMessage"
QUARTER = math.pi / 2
MAP = ("map", "odom", Pose(5, heading=QUARTER))
WHEELS = ("odom", "base_footprint", Pose(1))
BODY = ("base_footprint", "base_link", Pose(0.25, heading=QUARTER))
FIXED: Mapping[str, Any] = {STATIC: True}


def test_a_pose_in_tf_is_that_of_the_robot_in_the_root() -> None:
    """The stamp is that of the wheels: a correction of the map moves the robot only when they are heard again."""
    poses = PoseReader()
    poses.bases = {"anna": "tb1/base_link"}

    def hear(*messages: tuple[bytes, Mapping[str, Any]]) -> list[tuple[str, float, float, int]]:
        found = poses.take([Polled(["anna"], "/tb1/tf", "tf2_msgs/TFMessage", messages)])
        return [
            (each.frame, round(each.pose.x, 6), round(each.pose.y, 6), round(math.degrees(each.pose.heading)))
            for each in found
        ]

    assert hear((transforms(BODY, at=0), FIXED)) == [("base_footprint", 0.25, 0, 90)]
    assert hear((transforms(WHEELS), {})) == [("odom", 1.25, 0, 90)]
    assert hear((transforms(MAP), {})) == []
    assert hear((transforms(WHEELS, at=4), {})) == [("map", 5, 1.25, 180)]
    assert hear((b"\0\1\0\0", {})) == []


def test_robots_that_share_tf_have_frames_with_their_namespaces() -> None:
    poses = PoseReader()
    poses.bases = {"anna": "tb1/base_link", "bert": "tb2/base_link", "carl": "tb3/base_link"}
    heard = transforms(
        ("map", "tb1/base_link", Pose(1)), ("/map", "/tb2/base_link", Pose(2)), ("map", "base_link", Pose(3))
    )
    found = poses.take([Polled(["anna", "bert", "carl"], "/tf", "tf2_msgs/TFMessage", [(heard, {})])])
    assert [(each.robot, each.frame, each.pose.x) for each in found] == [("anna", "map", 1), ("bert", "map", 2)]


def test_frames_in_a_circle_have_no_root() -> None:
    heard = transforms(("odom", "base_link", Pose(1)), ("base_link", "odom", Pose(1)))
    assert PoseReader().take([Polled(["anna"], "/anna/tf", "tf2_msgs/TFMessage", [(heard, {})])]) == []


@pytest.mark.parametrize("length", range(5))
def test_a_message_without_content_has_nothing_to_read(length: int) -> None:
    message = b"\0\1\0\0"[:length]
    assert [pose_in(message, 1), twist_in(message, True), twist_in(message, False)] == [None] * 3
    assert [transforms_in(message), joints_in(message)] == [[], {}]


@given(st.binary(max_size=300), st.booleans())
def test_broken_transforms_are_refused(body: bytes, whole: bool) -> None:
    message = transforms(MAP, WHEELS)
    assert isinstance(transforms_in((message[:40] if whole else b"\0\1\0\0") + body), list)


@pytest.mark.parametrize("kind", POSE_TEXTS)
@settings(max_examples=10)
@given(frame=st.text(max_size=9), child=st.text(max_size=9), heading=st.floats(-3.1, 3.1), x=st.floats(-9, 9))
def test_poses_and_stamps_of_each_message_are_read(kind: str, frame: str, child: str, heading: float, x: float) -> None:
    written = message(kind, Pose(x, -2, 0.5, heading), (frame, child))
    pose = pose_in(written, POSE_TEXTS[kind])
    assert pose
    assert stamp_in(written) == 3 * SECOND + 5
    assert (pose.x, pose.y, pose.z) == (x, -2, 0.5)
    assert pose.heading == pytest.approx(heading)


@pytest.mark.parametrize("kind", POSE_TEXTS)
def test_broken_poses_are_refused(kind: str) -> None:
    for wrong in (math.nan, math.inf, 1e300):
        assert pose_in(message(kind, Pose(wrong)), POSE_TEXTS[kind]) is None
        assert pose_in(message(kind, Pose(), z=wrong, w=wrong), POSE_TEXTS[kind]) is None
    assert pose_in(message(kind, Pose(), z=0.0, w=0.0), POSE_TEXTS[kind]) is None
    assert pose_in(message(kind, Pose())[:40], POSE_TEXTS[kind]) is None


def test_a_robot_that_leans_has_a_heading() -> None:
    roll, half = math.radians(10) / 2, math.radians(120) / 2  # it is turned first and leans then
    leaning: dict[str, Any] = {
        "x": math.cos(half) * math.sin(roll),
        "y": math.sin(half) * math.sin(roll),
        "z": math.sin(half) * math.cos(roll),
        "w": math.cos(half) * math.cos(roll),
    }
    pose = pose_in(message("geometry_msgs/PoseStamped", Pose(), **leaning), 1)
    assert pose
    assert math.degrees(pose.heading) == pytest.approx(120)
