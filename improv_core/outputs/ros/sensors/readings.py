"""The values of senses in sensors' messages. Standard library only: a message is any object with the right fields.

Readings of distances follow REP 117: NaN is no reading, -inf is too close to measure, and inf is nothing in sight.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from improv_core.score.senses import Message, Topic

_TURN = 2 * math.pi
_MAX_TURNS = 2
"""The most turns of a valid scan, and the farthest that it may start from straight ahead."""
_SLACK = 0.01
"""Tolerance in increments: angles are 32-bit floats, so a reading on the edge of a sector may be barely outside."""


def holds(topic: Topic, message: Any) -> bool | None:
    """Return the value of a sense in a message on its topic; None if the message has none."""
    if topic.message == "std_msgs/Bool":
        return bool(message.data)
    if topic.message == "sensor_msgs/Joy":
        return _pressed(message.buttons, topic.button)
    number = _NUMBERS[topic.message](topic, message)
    return None if number is None or math.isnan(number) else topic.compare(number)


def battery(message: Any) -> float | None:
    """The level of a battery in a sensor_msgs/BatteryState, from 0 to 1; None if it has none.

    The message defines a share from 0 to 1, but some drivers send percent.
    """
    share = float(message.percentage)
    if not 0 <= share <= 100:  # NaN if it isn't measured
        return None
    return share if share <= 1 else share / 100


def _pressed(buttons: Sequence[int], button: int | None) -> bool | None:
    if button is None:
        return any(buttons)
    return bool(buttons[button]) if button < len(buttons) else None


def _scanned(topic: Topic, scan: Any) -> float | None:
    places = _sector(topic.start, topic.end, scan.angle_min, scan.angle_increment, len(scan.ranges))
    readings = (reading for place in places for reading in scan.ranges[place])
    return _nearest(readings, scan.range_min, scan.range_max)


def _ranged(topic: Topic, message: Any) -> float | None:
    return _nearest([message.range], message.min_range, message.max_range)


def _nearest(readings: Iterable[float], least: float, most: float) -> float | None:
    """The nearest reading, in meters; None if there is none. Beyond the sensor's maximum, nothing is in sight."""
    if least == math.inf:
        return None
    nearest = min((each for each in readings if each >= least or each == -math.inf), default=None)
    return math.inf if nearest is not None and nearest > most else nearest


@lru_cache(maxsize=1_000)
def _sector(start: float, end: float, first: float, step: float, count: int) -> Sequence[slice]:
    """The readings of a scan from one angle to another. Angles may increase or decrease, and wrap around."""
    if not count or not abs(first) <= _MAX_TURNS * _TURN or not abs(step) * count <= _MAX_TURNS * _TURN:
        return ()
    turns = [each * _TURN - first for each in range(-2 * _MAX_TURNS - 1, 2 * _MAX_TURNS + 2)]
    if not step:
        # A sensor with one beam needs no increment. More readings at one angle are malformed.
        return [slice(0, 1)] if count == 1 and any(start + turn <= 0 <= end + turn for turn in turns) else ()
    found = []
    for turn in turns:
        near, far = sorted(((start + turn) / step, (end + turn) / step))
        begin, stop = max(math.ceil(near - _SLACK), 0), min(math.floor(far + _SLACK) + 1, count)
        if begin < stop:
            found.append(slice(begin, stop))
    return found


_NUMBERS: Mapping[Message, Callable[[Topic, Any], float | None]] = {
    "sensor_msgs/LaserScan": _scanned,
    "sensor_msgs/Range": _ranged,
    "std_msgs/Float32": lambda topic, message: float(message.data),
    "nav_msgs/Odometry": lambda topic, message: math.hypot(
        message.twist.twist.linear.x, message.twist.twist.linear.y, message.twist.twist.linear.z
    ),
}
