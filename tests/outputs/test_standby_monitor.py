"""The rules by which a standby is replaced, and by which robots stop without one, at times that the tests set."""

from __future__ import annotations

import pytest

from improv_core.outputs.ros.standby.client import ANSWER_LIMIT, READY_LIMIT, START_LIMIT, StandbyMonitor

PERIOD = 0.1


def lost_at(answers_until: float, pulses_from: float, stalls_at: float | None, moves_from: float = 0.0) -> float | None:
    """Return the time at which a standby that answers pulses only up to a time counts as lost; None if not within 10
    s. Robots begin to move at another time."""
    monitor, now = StandbyMonitor(0.0), 0.0
    while now < 10:
        if now <= answers_until:
            monitor.note_message()
        monitor.note_time(now)
        if monitor.is_lost():
            return round(now, 6)
        if now >= pulses_from:
            monitor.note_pulse(now, now >= moves_from)
        now = round(now + (3.0 if now == stalls_at else PERIOD), 6)
    return None


@pytest.mark.parametrize(
    ("answers_until", "pulses_from", "stalls_at", "expected"),
    [
        (10.0, 0.0, None, None),
        (2.0, 0.0, None, 2.0 + ANSWER_LIMIT),
        (-1.0, 0.0, None, START_LIMIT),
        (2.0, 4.0, None, 4.0 + ANSWER_LIMIT),
        (10.0, 0.0, 2.0, None),
        (2.0, 0.0, 2.2, 2.2 + 3.0 + 0.3),
    ],
    ids=["it answers", "it falls silent", "it never starts", "nobody asks", "we stall", "we stall, and it is silent"],
)
def test_a_standby_that_does_not_answer_is_lost(
    answers_until: float, pulses_from: float, stalls_at: float | None, expected: float | None
) -> None:
    assert lost_at(answers_until, pulses_from, stalls_at) == (expected and round(expected, 6))


@pytest.mark.parametrize(
    ("moves_from", "expected"), [(0.0, 2.0 + ANSWER_LIMIT), (4.0, 4.0 + ANSWER_LIMIT), (20.0, 2.0 + START_LIMIT)]
)
def test_a_standby_has_more_time_to_answer_while_robots_stand(moves_from: float, expected: float) -> None:
    assert lost_at(2.0, 0.0, None, moves_from) == expected


def stops(*story: tuple[bool, bool]) -> list[float]:
    """Return the times at which robots are stopped, given for each second whether they move, and whether a standby is
    ready."""
    monitor, found = StandbyMonitor(0.0), []
    for second, (moving, ready) in enumerate(story):
        monitor.note_time(float(second))
        if monitor.must_stop(moving, ready):
            found.append(float(second))
    return found


GUARDED, UNGUARDED, STILL, ALONE = (True, True), (True, False), (False, True), (False, False)
LONG = int(READY_LIMIT)


@pytest.mark.parametrize(
    ("story", "expected"),
    [
        ([GUARDED] * 20, []),
        ([GUARDED, *[UNGUARDED] * LONG, GUARDED], []),
        ([GUARDED, *[UNGUARDED] * (LONG + 1)], [1.0 + LONG]),
        ([ALONE] * 20, []),
        ([*[ALONE] * 20, *[UNGUARDED] * (LONG + 1)], [20.0 + LONG]),
        ([*[UNGUARDED] * LONG, STILL, *[UNGUARDED] * LONG], []),
    ],
    ids=["guarded", "replaced in time", "never ready", "nobody moves", "from when they move", "two short times"],
)
def test_robots_that_move_without_a_standby_are_stopped(story: list[tuple[bool, bool]], expected: list[float]) -> None:
    assert stops(*story) == expected
