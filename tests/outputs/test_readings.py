"""Values of senses in messages, including messages that no sensor should send."""

from __future__ import annotations

import math
from array import array
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.outputs.ros.sensors.readings import battery, holds
from improv_core.score.senses import Topic

NAN, INF = math.nan, math.inf
AHEAD = Topic("/scan", "sensor_msgs/LaserScan", below=0.5, start=-math.radians(30), end=math.radians(30))
RANGE = Topic("/range", "sensor_msgs/Range", below=0.5)


def scan(ranges: dict[int, float] | list[float], first: float = -180, step: float = 1, **other: float) -> Any:
    """A scan from an angle on, in degrees. In a dict by angle, all other readings of the turn are 2 m."""
    angles = [(round(first + place * step) + 180) % 360 - 180 for place in range(360)]
    readings = [ranges.get(angle, 2.0) for angle in angles] if isinstance(ranges, dict) else ranges
    start, increment = (array("f", [math.radians(each)])[0] for each in (first, step))
    fields = {"angle_min": start, "angle_max": 0.0, "angle_increment": increment, "range_min": 0.1, "range_max": 10.0}
    return SimpleNamespace(**{**fields, **other}, ranges=array("f", readings))


@pytest.mark.parametrize(("first", "step"), [(-180, 1), (0, 1), (180, -1), (-90, 1), (360, -1)])
@pytest.mark.parametrize(
    ("angle", "expected"), [(0, True), (30, True), (-30, True), (31, False), (-31, False), (180, False)]
)
def test_the_sector_of_a_scan_is_found(angle: int, expected: bool, first: float, step: float) -> None:
    assert holds(AHEAD, scan({angle: 0.4}, first, step)) is expected


def test_a_sector_may_be_behind_the_robot() -> None:
    behind = replace(AHEAD, start=math.radians(150), end=math.radians(210))
    for first in (-180, 0):
        assert holds(behind, scan({-170: 0.4}, first)) is True
        assert holds(behind, scan({0: 0.4}, first)) is False


@pytest.mark.parametrize(
    ("readings", "below", "above"),
    [
        ({0: 0.4}, True, False),
        ({0: 0.6}, False, True),
        ({0: -INF}, True, False),
        ({0: INF}, False, True),
        ({0: 0.05}, False, True),
        ({0: 0.0}, False, True),
        ({0: NAN}, False, True),
        ({0: NAN, 1: 0.4, 2: NAN}, True, False),
        ([INF] * 360, False, True),
        ([11.0] * 360, False, True),
        ([NAN] * 360, None, None),
        ([0.0] * 360, None, None),
        ([], None, None),
    ],
)
def test_readings_of_a_scan_are_compared(readings: Any, below: bool | None, above: bool | None) -> None:
    assert holds(AHEAD, scan(readings)) is below
    assert holds(replace(AHEAD, below=None, above=0.5), scan(readings)) is above


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        (scan([0.4] * 360, step=0), None),
        (scan([0.4], first=0, step=0), True),
        (scan([0.4], first=90, step=0), None),
        (scan([0.4] * 3, first=0), True),
        (scan([0.4] * 3, first=90), None),
        (scan([0.4] * 5000, step=1), None),
        (scan([0.4] * 360, angle_increment=NAN), None),
        (scan([0.4] * 360, angle_increment=INF), None),
        (scan([0.4] * 360, angle_increment=1e-40), None),
        (scan([0.4] * 360, angle_min=NAN), None),
        (scan([0.4] * 360, angle_min=-INF), None),
        (scan([0.4] * 360, angle_min=1e30), None),
        (scan([0.4] * 360, range_min=NAN), None),
        (scan([0.4] * 360, range_max=NAN), True),
        (scan([0.4] * 360, range_min=INF), None),
        (scan([INF] * 360, range_min=INF), None),
    ],
)
def test_malformed_scans_are_read_safely(wrong: Any, expected: bool | None) -> None:
    assert holds(AHEAD, wrong) is expected


numbers = st.floats(width=32) | st.sampled_from([0.0, -0.0, NAN, INF, -INF])


@given(st.lists(numbers, max_size=50), *[numbers] * 4)
def test_no_scan_raises(readings: list[float], first: float, step: float, least: float, most: float) -> None:
    message = scan(readings, angle_min=first, angle_increment=step, range_min=least, range_max=most)
    assert holds(AHEAD, message) in (True, False, None)


def range_of(reading: float, least: float = 0.1, most: float = 4.0) -> Any:
    return SimpleNamespace(range=reading, min_range=least, max_range=most)


def number(value: float) -> Any:
    return SimpleNamespace(data=value)


def buttons(*held: int) -> Any:
    return SimpleNamespace(buttons=held)


def odometry(speed: float) -> Any:
    linear = SimpleNamespace(x=0.0, y=speed, z=0.0)
    return SimpleNamespace(twist=SimpleNamespace(twist=SimpleNamespace(linear=linear)))


NUMBER = Topic("/x", "std_msgs/Float32", below=-0.5)
MOVES = Topic("/x", "nav_msgs/Odometry", above=0.0)
ANY, SECOND = (Topic("/joy", "sensor_msgs/Joy", button=button) for button in (None, 1))
HIT = Topic("/hit", "std_msgs/Bool")


@pytest.mark.parametrize(
    ("topic", "message", "expected"),
    [
        (RANGE, range_of(0.4), True),
        (RANGE, range_of(0.6), False),
        (RANGE, range_of(0.05), None),
        (RANGE, range_of(5.0), False),
        (RANGE, range_of(NAN), None),
        (RANGE, range_of(-INF, 1.0, 1.0), True),
        (RANGE, range_of(INF, 1.0, 1.0), False),
        (NUMBER, number(-1.0), True),
        (NUMBER, number(0.0), False),
        (NUMBER, number(NAN), None),
        (NUMBER, number(INF), False),
        (NUMBER, number(-INF), True),
        (MOVES, odometry(-1.0), True),
        (MOVES, odometry(0.0), False),
        (MOVES, odometry(NAN), None),
        (ANY, buttons(0, 0), False),
        (ANY, buttons(0, 1), True),
        (ANY, buttons(), False),
        (SECOND, buttons(0, 1), True),
        (SECOND, buttons(1, 0), False),
        (SECOND, buttons(1), None),
        (HIT, SimpleNamespace(data=True), True),
        (HIT, SimpleNamespace(data=False), False),
    ],
)
def test_other_messages_are_read(topic: Topic, message: Any, expected: bool | None) -> None:
    assert holds(topic, message) is expected


@pytest.mark.parametrize(
    ("percentage", "share"),
    [(0.0, 0.0), (0.42, 0.42), (1.0, 1.0), (42.0, 0.42), (100.0, 1.0), (101.0, None), (-1.0, None), (math.nan, None)],
)
def test_battery_levels_are_shares_or_percent(percentage: float, share: float | None) -> None:
    assert battery(SimpleNamespace(percentage=percentage)) == share
