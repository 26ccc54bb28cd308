"""Serialized `geometry_msgs/Twist`, `TwistStamped`, and `std_msgs/String`. Standard library only.

CDR, little-endian (OMG DDS-XTypes 1.3, 7.4.1): after a four-byte header, each field is aligned to its own size. An
empty string is its length, 1, and a zero byte; three more bytes align the first float64.
"""

from __future__ import annotations

import struct

from improv_core.score.motion import Twist

SECOND = 1_000_000_000
"""In nanoseconds."""

_HEADER = b"\x00\x01\x00\x00"
_TWIST = struct.Struct("<4s6d")
_STAMP = struct.Struct("<4siII4x")
_VELOCITY = slice(len(_HEADER), None)


def twist_message(twist: Twist) -> bytes:
    """A Twist. Whole numbers may be ints."""
    return _TWIST.pack(_HEADER, twist.x, twist.y, twist.z, 0.0, 0.0, twist.yaw)


def string_message(text: str) -> bytes:
    """A `std_msgs/String`."""
    data = text.encode() + b"\0"
    return _HEADER + struct.pack("<I", len(data)) + data


def string_of(message: bytes) -> str:
    """The text of a `std_msgs/String`. Raises ValueError if it is none."""
    if message[: len(_HEADER)] != _HEADER or not message.endswith(b"\0"):
        raise ValueError("it is not a std_msgs/String")
    return message[len(_HEADER) + 4 : -1].decode()


def stamped(message: bytes, time: int) -> bytes:
    """A Twist as a TwistStamped of this time, in nanoseconds."""
    return _STAMP.pack(_HEADER, *divmod(time, SECOND), 1) + message[_VELOCITY]
