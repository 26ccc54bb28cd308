"""Serialized ROS messages: velocities, texts, poses, and commands for joints. Standard library only.

CDR, little-endian (OMG DDS-XTypes 1.3, 7.4.1): after a four-byte header, each field is aligned to its own size. A
string is its length, its bytes, and a zero byte.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from improv_core.score.motion import Pose, Twist

if TYPE_CHECKING:  # see __init__.py
    from improv_core.score.joints import JointMotion

SECOND = 1_000_000_000
"""Nanoseconds in a second."""

LARGEST = 1e9
"""The largest number allowed in a pose, in meters. Sums and products of larger ones could become infinite or NaN."""

MAX_TRANSFORMS = 1_000
"""The most transforms that are read from one message."""

MAX_JOINTS = 1_000
"""The most joints that are read from one message. No robot has more."""

POSE_TEXTS = {"nav_msgs/Odometry": 2, "geometry_msgs/PoseStamped": 1, "geometry_msgs/PoseWithCovarianceStamped": 1}
"""The messages with a pose after a stamp, and the number of texts (names of frames) in between."""

_HEADER = b"\x00\x01\x00\x00"
_TWIST = struct.Struct("<4s6d")
_STAMP = struct.Struct("<4siI")
_VELOCITY = slice(len(_HEADER), None)


def twist_message(twist: Twist) -> bytes:
    """A Twist. Whole numbers may be ints."""
    return _TWIST.pack(_HEADER, twist.x, twist.y, twist.z, 0.0, 0.0, twist.yaw)


def string_message(text: str) -> bytes:
    return _HEADER + _string(text)


def string_of(message: bytes) -> str:
    """The text of a `std_msgs/String`. Raises ValueError if it is not one."""
    if message[: len(_HEADER)] != _HEADER or not message.endswith(b"\0"):
        raise ValueError("it is not a std_msgs/String")
    return message[len(_HEADER) + 4 : -1].decode()


def stamped(message: bytes, time: int, frame: str) -> bytes:
    """A Twist as a TwistStamped of this time, in nanoseconds, and this frame."""
    return _stamp(time, frame) + message[_VELOCITY]


def _stamp(time: int, frame: str) -> bytes:
    return _STAMP.pack(_HEADER, *divmod(time, SECOND)) + _frame_field(frame)


@lru_cache(maxsize=1_000)
def _frame_field(frame: str) -> bytes:
    """Return a `frame_id`, padded so that the numbers after it are aligned."""
    data = _string(frame)
    return data + bytes(-len(data) % 8)  # the stamp before it has eight bytes


def numbers_message(numbers: Sequence[float]) -> bytes:
    """A std_msgs/Float64MultiArray with these numbers and an empty layout."""
    return struct.pack(f"<4s3I4x{len(numbers)}d", _HEADER, 0, 0, len(numbers), *numbers)


def trajectory_message(
    joints: tuple[str, ...], points: Sequence[tuple[float, Sequence[float], Sequence[float]]]
) -> bytes:
    """A trajectory_msgs/JointTrajectory that begins when it arrives. Each point has the seconds from then, and the
    joints' positions and velocities."""
    body = bytearray(_trajectory_begin(joints))
    body += struct.pack("<I", len(points))
    for seconds, positions, velocities in points:
        for numbers in (positions, velocities):
            body += struct.pack("<I", len(numbers)) + bytes(-(len(body) + 4) % 8)
            body += struct.pack(f"<{len(numbers)}d", *numbers)
        body += struct.pack("<IIiI", 0, 0, *divmod(round(seconds * SECOND), SECOND))  # no accelerations, no efforts
    return _HEADER + bytes(body)


@lru_cache(maxsize=1_000)
def _trajectory_begin(joints: tuple[str, ...]) -> bytes:
    """The header of a trajectory, stamped 0, and the names of its joints."""
    body = bytearray(8) + _string("")
    for part in (struct.pack("<I", len(joints)), *map(_string, joints)):
        body += bytes(-len(body) % 4) + part
    return bytes(body + bytes(-len(body) % 4))


def pose_message(pose: Pose, time: int, frame: str) -> bytes:
    """A geometry_msgs/PoseStamped of this time, in nanoseconds, and this frame."""
    half = pose.heading / 2
    return _stamp(time, frame) + struct.pack("<7d", pose.x, pose.y, pose.z, 0.0, 0.0, math.sin(half), math.cos(half))


def joint_state_message(joints: Mapping[str, JointMotion], time: int) -> bytes:
    """A sensor_msgs/JointState of this time, in nanoseconds: positions and velocities of joints, and no efforts."""
    body = bytearray(struct.pack("<iI", *divmod(time, SECOND)) + _string(""))
    for part in (struct.pack("<I", len(joints)), *map(_string, joints)):
        body += bytes(-len(body) % 4) + part
    for numbers in ([each.position for each in joints.values()], [each.velocity for each in joints.values()]):
        body += bytes(-len(body) % 4) + struct.pack("<I", len(numbers))
        body += bytes(-len(body) % 8) + struct.pack(f"<{len(numbers)}d", *numbers)
    return _HEADER + bytes(body) + struct.pack("<I", 0)


def stamp_in(message: bytes) -> int:
    """The time in a message that begins with a header, in nanoseconds; 0 if it has no stamp."""
    seconds, nanoseconds = struct.unpack_from(f"{_order(message)}iI", message, len(_HEADER))
    return int(seconds * SECOND + nanoseconds)


def frame_in(message: bytes) -> str:
    """The frame in a message that begins with a header. Bytes that aren't text become replacement characters."""
    return _text(memoryview(message)[len(_HEADER) :], 8, _order(message))[0]  # after the stamp


def pose_in(message: bytes, texts: int) -> Pose | None:
    """Return the pose in a message that begins with a stamp and then this many texts; None if it isn't a valid pose.

    An odometry has 72 more numbers, which nobody needs. If all four numbers of the orientation are 0, it has none.
    """
    order, body, place = _order(message), memoryview(message)[len(_HEADER) :], 8  # after the stamp
    try:
        for _ in range(texts):
            _, place = _text(body, _aligned(place, 4), order)
        return _placed(struct.unpack_from(f"{order}7d", body, _aligned(place, 8)))
    except struct.error:
        return None


def _placed(numbers: Sequence[float]) -> Pose | None:
    """Return the pose of a place and an orientation, if they are valid."""
    x, y, z, *turn = numbers
    i, j, k, w = turn
    if not all(abs(each) <= LARGEST for each in (x, y, z, *turn)) or not any(turn):
        return None
    return Pose(x, y, z, math.atan2(2 * (w * k + i * j), w * w + i * i - j * j - k * k))


class Transform(NamedTuple):
    """The pose of the frame `child` in the frame `parent`, at a time in nanoseconds (0: it has none)."""

    parent: str
    child: str
    pose: Pose
    stamp: int


def transforms_in(message: bytes) -> list[Transform]:
    """Return the transforms in a tf2_msgs/TFMessage, except invalid ones; none if the message can't be read."""
    order, body, found = _order(message), memoryview(message)[len(_HEADER) :], list[Transform]()
    try:
        (count,) = struct.unpack_from(f"{order}I", body)
        place = 4
        for _ in range(min(count, MAX_TRANSFORMS)):
            seconds, nanoseconds = struct.unpack_from(f"{order}iI", body, place := _aligned(place, 4))
            parent, place = _text(body, place + 8, order)
            child, place = _text(body, _aligned(place, 4), order)
            pose = _placed(struct.unpack_from(f"{order}7d", body, place := _aligned(place, 8)))
            place += 56
            if pose:
                found.append(Transform(parent, child, pose, seconds * SECOND + nanoseconds))
    except (struct.error, IndexError):
        return []
    return found


def joints_in(message: bytes) -> dict[str, float]:
    """The positions in a sensor_msgs/JointState by joint, without those that aren't numbers; empty if unreadable."""
    order, body = _order(message), memoryview(message)[len(_HEADER) :]
    try:
        _, place = _text(body, 8, order)  # after the stamp
        (count,) = struct.unpack_from(f"{order}I", body, place := _aligned(place, 4))
        place += 4
        names = []
        for _ in range(min(count, MAX_JOINTS)):
            name, place = _text(body, _aligned(place, 4), order)
            names.append(name)
        (found,) = struct.unpack_from(f"{order}I", body, place := _aligned(place, 4))
        if not len(names) == count == found:
            return {}
        positions = struct.unpack_from(f"{order}{count}d", body, _aligned(place + 4, 8)) if count else ()
    except (struct.error, IndexError):
        return {}
    return {name: value for name, value in zip(names, positions, strict=True) if abs(value) <= LARGEST}


def twist_in(message: bytes, is_stamped: bool) -> Twist | None:
    """Return the velocity in a Twist or TwistStamped; None if it isn't a valid one."""
    order, place = _order(message), len(_HEADER)
    try:
        if is_stamped:
            (length,) = struct.unpack_from(f"{order}I", message, place + 8)
            place += _aligned(12 + length, 8)
        x, y, z, _, _, yaw = struct.unpack_from(f"{order}6d", message, place)
    except struct.error:
        return None
    return Twist(x, y, z, yaw) if all(abs(each) <= LARGEST for each in (x, y, z, yaw)) else None


def _order(message: bytes) -> str:
    """Return the byte order of a message; of one that is too short to have any, it doesn't matter."""
    return "<" if len(message) > 1 and message[1] & 1 else ">"


def _text(body: memoryview, place: int, order: str) -> tuple[str, int]:
    """Return a text and the offset at which it ends."""
    (length,) = struct.unpack_from(f"{order}I", body, place)
    return bytes(body[place + 4 : place + 4 + length]).rstrip(b"\0").decode(errors="replace"), place + 4 + length


def _aligned(place: int, size: int) -> int:
    return place + -place % size


def _string(text: str) -> bytes:
    data = text.encode() + b"\0"
    return struct.pack("<I", len(data)) + data
