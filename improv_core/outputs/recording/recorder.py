"""Records velocities in an MCAP file that `ros2 bag play` and Foxglove can read (mcap, imported lazily)."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from itertools import chain
from typing import IO

from improv_core.outputs.cdr import (
    SECOND,
    joint_state_message,
    pose_message,
    stamped,
    string_message,
    string_of,
    twist_message,
)
from improv_core.protocol.decoding import read_as
from improv_core.protocol.messages import Decided, FromStage, Sensed, Sent
from improv_core.protocol.robot_messages import Measured
from improv_core.score.joints import JointMotion
from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import Score

_VECTOR3 = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z"
_TWIST = "Vector3 linear\nVector3 angular"
_HEADER = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id"
_TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec"
_POSE = "MSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation"
_POINT = "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z"
_QUATERNION = "MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1"
_JOINTS = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
_BETWEEN = f"\n{'=' * 80}\n"
SCHEMAS = {
    "std_msgs/msg/String": "string data",
    "geometry_msgs/msg/Twist": _BETWEEN.join([_TWIST, _VECTOR3]),
    "geometry_msgs/msg/TwistStamped": _BETWEEN.join(
        ["std_msgs/Header header\nTwist twist", f"MSG: geometry_msgs/Twist\n{_TWIST}", _VECTOR3, _HEADER, _TIME]
    ),
    "geometry_msgs/msg/PoseStamped": _BETWEEN.join(
        ["std_msgs/Header header\nPose pose", _POSE, _POINT, _QUATERNION, _HEADER, _TIME]
    ),
    "sensor_msgs/msg/JointState": _BETWEEN.join([_JOINTS, _HEADER, _TIME]),
}
"""Each message and its components, in the order that `ros2msg` requires, separated by its lines of 80 `=`."""

# The QoS that outputs/ros/output.py offers: keep last 10, reliable, volatile. Written as numbers, as in rosbag2 up to
# Iron: later releases understand both forms, Humble only this one. A duration of 9223372036.854775807 s means infinite.
_ENDLESS = "{sec: 9223372036, nsec: 854775807}"
OFFERED_QOS_PROFILES = f"""\
- history: 1
  depth: 10
  reliability: 1
  durability: 2
  deadline: {_ENDLESS}
  lifespan: {_ENDLESS}
  liveliness: 1
  liveliness_lease_duration: {_ENDLESS}
  avoid_ros_namespace_conventions: false
"""


CHANNELS = {"sensed": "/improv/sensed", "decided": "/improv/decided"}
"""The topics of sensed and decided events, as JSON in a `std_msgs/String`, so that ROS 2 can play them too."""


def sensed_in(file: IO[bytes]) -> list[Sensed]:
    """The sensed edges in a recording, up to the first restart. Raises ValueError if it can't be read."""
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    try:
        messages = [message for *_, message in make_reader(file).iter_messages(topics=[CHANNELS["sensed"]])]
    except (McapError, struct.error):
        raise ValueError("it is not a recording") from None
    sensed: list[Sensed] = []
    for message in messages:
        edge: FromStage = read_as(string_of(message.data).encode(), FromStage)
        if edge["type"] == "sensed" and edge["generation"] == (sensed[0] if sensed else edge)["generation"]:
            sensed.append(edge)
    return sensed


class Recorder:
    """Records the robots' commands on their topics, calibrated and limited as real robots get them.

    `start` is the Unix time of beat 0, in nanoseconds. `finish` completes the file, which the caller closes. It is
    written in chunks of 1 MiB. Only the index is kept in memory, about a hundred bytes per chunk.
    """

    def __init__(self, file: IO[bytes], start: int) -> None:
        from mcap.writer import Writer

        self._writer = Writer(file)
        self._writer.start(profile="ros2")
        self._start = start
        self._robots: dict[str, tuple[Profile, str, str]] = {}  # with the frame and the topic of each
        self._poses: dict[str, str] = {}  # the topics of measured poses
        self._joints: dict[str, str] = {}  # the topics of joints
        self._held: dict[str, list[tuple[bytes, str, int]]] = {}  # velocities on topics whose type isn't known yet
        self._stamped: dict[str, bool] = {}
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._times: tuple[int, int] | None = None
        self.setpoints = 0
        """The number of setpoints recorded."""

    @property
    def robots(self) -> int:
        """The number of robots prepared so far."""
        return len(self._robots)

    @property
    def seconds(self) -> float:
        """The time from the first command to the last."""
        return (self._times[1] - self._times[0]) / SECOND if self._times else 0.0

    def prepare(self, score: Score) -> None:
        """Get to know the robots of a score before the first `take` of it."""
        for robot, part in score.parts.items():
            self._robots[robot] = part.profile, part.frame, part.topic
            # Topics of our own: when a recording is played, nothing must take them for what a robot measures then.
            if part.odom:
                self._poses[robot] = f"/improv{part.namespace}/pose"
            if part.profile.body:
                self._joints[robot] = f"/improv{part.namespace}/joint_states"

    def time(self, at: float) -> int:
        """The Unix time in nanoseconds of a performance time."""
        return self._start + round(at * SECOND)

    def take(self, message: Sent | Measured | Sensed | Decided) -> None:
        """Record a message of a stage at its own time. Raises ValueError if a command isn't finite, and OSError."""
        if message["type"] == "measured":
            self._record_poses(message)
        elif message["type"] != "sent":
            self.note(message, message["wall"])
        else:
            if "twist" in message:
                self._record_twist(message, Twist(*message["twist"]))
            if "joints" in message:
                self._record_joints(message, {name: JointMotion(*each) for name, each in message["joints"].items()})

    def note(self, message: Sensed | Decided, time: int) -> None:
        """Record an event that was sensed or decided, as JSON, at a Unix time in nanoseconds. Raises OSError."""
        self._write(CHANNELS[message["type"]], "std_msgs/msg/String", time, string_message(json.dumps(message)))

    def _record_twist(self, message: Sent, twist: Twist) -> None:
        """Record a velocity. A topic has one type: the first that is known to have been sent."""
        robot, time, is_stamped = message["robot"], message["wall"], message.get("stamped")
        if not all(map(math.isfinite, (twist.x, twist.y, twist.z, twist.yaw))):
            raise ValueError(f"{robot} was given a speed that is not a finite number")
        profile, frame, own_topic = self._robots[robot]
        topic = message.get("topic") or own_topic
        if profile.message != "auto":
            is_stamped = profile.message == "TwistStamped"
        self._held.setdefault(topic, []).append((twist_message(profile.command_for(twist)), frame, time))
        if is_stamped is not None:
            self._stamped.setdefault(topic, is_stamped)
        if topic in self._stamped:
            self._write_held(topic)
        first, last = self._times or (time, time)
        self._times = min(first, time), max(last, time)
        self.setpoints += 1

    def _record_poses(self, message: Measured) -> None:
        """Record the measured poses of robots in the frames of their sources."""
        for robot, each in message["robots"].items():
            if topic := self._poses.get(robot):
                pose = Pose(**each["origin"]).then(Pose(**each["pose"]))
                data = pose_message(pose, each["wall"], each["frame"] or "world")
                self._write(topic, "geometry_msgs/msg/PoseStamped", each["wall"], data)

    def _record_joints(self, message: Sent, joints: Mapping[str, JointMotion]) -> None:
        """Record a movement of joints."""
        robot, time = message["robot"], message["wall"]
        if not all(map(math.isfinite, chain.from_iterable(joints.values()))):
            raise ValueError(f"a joint of {robot} was given a position or a speed that is not a finite number")
        if topic := self._joints.get(robot):
            self._write(topic, "sensor_msgs/msg/JointState", time, joint_state_message(joints, time))

    def finish(self) -> None:
        """Write the index at the end of the file. Without it, the file can't be played. Raises OSError."""
        for topic in self._held:
            self._write_held(topic)
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _write_held(self, topic: str) -> None:
        is_stamped = self._stamped.get(topic, False)
        kind = f"geometry_msgs/msg/{'TwistStamped' if is_stamped else 'Twist'}"
        for data, frame, time in self._held[topic]:
            self._write(topic, kind, time, stamped(data, time, frame) if is_stamped else data)
        self._held[topic].clear()

    def _write(self, topic: str, kind: str, time: int, data: bytes) -> None:
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", SCHEMAS[kind].encode())
        if topic not in self._channels:
            offered = {"offered_qos_profiles": OFFERED_QOS_PROFILES}
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[kind], offered)
        self._writer.add_message(self._channels[topic], log_time=time, publish_time=time, data=data)
