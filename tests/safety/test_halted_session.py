"""A session that was halted, and a stop that went straight to stages a moment before it continues."""

from __future__ import annotations

import time

import pytest

from improv_core.safety.stops import BEHIND, HALTED, KNOWN, Stops


@pytest.mark.parametrize(
    ("ran", "settles"),
    [
        ([], True),
        ([0.0], True),
        ([-HALTED - 0.1], False),
        ([-HALTED - 0.1, 0.0], False),
        ([-HALTED - 0.1, None], True),
        ([-KNOWN - HALTED - 0.4, -KNOWN - 0.2, -KNOWN, 0.0], True),
    ],
)
def test_a_stop_settles_later_if_what_arrives_with_it_may_have_waited_since_before_it(
    ran: list[float | None], settles: bool
) -> None:
    """Each number is a time at which the session ran, in seconds from now; None is a rest."""
    stops, now = Stops(), time.monotonic()
    for at in ran:
        stops.halts.rests() if at is None else stops.halts.runs(now + at)
    stops.arrive({"type": "stop", "direct": "x", "at": now - BEHIND / 2})
    assert stops.has_settled("x") == settles
