"""Serialized `geometry_msgs/Twist`, `TwistStamped`, and `std_msgs/String`. Standard library only.

CDR, little-endian (OMG DDS-XTypes 1.3, 7.4.1): after a four-byte header, each field is aligned to its own size. A
string is its length, its bytes, and a zero byte.
"""

from __future__ import annotations

import struct

from improv_core.score.motion import Twist

SECOND = 1_000_000_000
"""In nanoseconds."""

_HEADER = b"\x00\x01\x00\x00"
_TWIST = struct.Struct("<4s6d")
_STAMP = struct.Struct("<4siI")
_VELOCITY = slice(len(_HEADER), None)


def twist_message(twist: Twist) -> bytes:
    """A Twist. Whole numbers may be ints."""
    return _TWIST.pack(_HEADER, twist.x, twist.y, twist.z, 0.0, 0.0, twist.yaw)


def string_message(text: str) -> bytes:
    """A `std_msgs/String`."""
    return _HEADER + _string(text)


def string_of(message: bytes) -> str:
    """The text of a `std_msgs/String`. Raises ValueError if it is none."""
    if message[: len(_HEADER)] != _HEADER or not message.endswith(b"\0"):
        raise ValueError("it is not a std_msgs/String")
    return message[len(_HEADER) + 4 : -1].decode()


def frame_field(frame: str) -> bytes:
    """The `frame_id` of a header, for `stamped`: as long as it takes to align the velocity after it."""
    data = _string(frame)
    return data + bytes(-len(data) % 8)  # the stamp before it has eight bytes


def stamped(message: bytes, time: int, frame: bytes) -> bytes:
    """A Twist as a TwistStamped of this time, in nanoseconds, and this `frame_field`."""
    return _STAMP.pack(_HEADER, *divmod(time, SECOND)) + frame + message[_VELOCITY]


def _string(text: str) -> bytes:
    data = text.encode() + b"\0"
    return struct.pack("<I", len(data)) + data
