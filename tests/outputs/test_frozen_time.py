"""The time on /clock: a simulation that is paused is told from one that is slow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from improv_core.outputs.ros.clock import FROZEN, NodeTime


@dataclass
class Clock:
    """A node and its clock, which shows this time in nanoseconds."""

    nanoseconds: int = 0
    ros_time_is_active: bool = True

    def now(self) -> Any:
        return self

    get_clock = now


@pytest.mark.parametrize(
    ("clock", "passes", "frozen"),
    [
        (Clock(1), 0, True),
        (Clock(1), 1, False),  # however slow it is
        (Clock(0), 0, False),  # nothing has come
        (Clock(1, ros_time_is_active=False), 0, False),
    ],
)
def test_a_simulation_is_paused_if_its_time_stands(clock: Clock, passes: int, frozen: bool) -> None:
    time, found = NodeTime(clock), []
    for step in range(11):
        found.append(time.is_frozen(step * FROZEN / 5))
        clock.nanoseconds += passes
    assert found == [frozen and step >= 5 for step in range(11)]
