"""Zeros that robots may not have received are sent again, on a clock that the tests advance."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from improv_core.safety.pending_zeros import (
    LATER,
    LIMIT,
    OVERDUE,
    PERIOD,
    UNCONFIRMED,
    FollowUp,
    TopicFacts,
    check,
    pending_zero,
)

RELIABLE = TopicFacts(1, confirms=True, confirmed=True)
LATE = TopicFacts(1, confirms=True, confirmed=False)
BEST_EFFORT = TopicFacts(1, confirms=False, confirmed=True)
GONE = TopicFacts(0, confirms=True, confirmed=True)
TELEOP = frozenset({"/teleop"})


def story(
    *facts: tuple[float, TopicFacts], listened: bool = True, inherited: bool = False
) -> tuple[list[float], float, bool]:
    """Send a robot a zero at 0; each of these facts holds from its time on.

    Returns the times of the repeated zeros, the time from which none is pending anymore, and whether people are warned.
    """

    def holds(now: float) -> TopicFacts:
        return [each for at, each in facts if at <= now][-1]

    pending, sent = pending_zero(0.0, holds(0.0).listeners, listened, inherited), list[float]()
    while True:
        now = round(pending.due, 6)
        found = check(pending, now, holds(now))
        if found.sends:
            sent.append(now)
        if not found.pending:
            return sent, now, found.warns
        assert found.pending.due > now
        pending = found.pending


def every(begin: float, end: float) -> list[float]:
    """The times of zeros that are sent from one time to another."""
    return [round(step * PERIOD, 3) for step in range(math.ceil(begin / PERIOD - 1e-6), round(end / PERIOD) + 1)]


@pytest.mark.parametrize(
    ("facts", "sent", "paid", "told"),
    [
        # Confirmed at once, or as soon as DDS asks: nothing more.
        ([(0, RELIABLE)], [], 0.2, False),
        ([(0, LATE), (1.3, RELIABLE)], every(0.2, 1.2), 1.4, False),
        # A listener that confirms nothing gets zeros for longer than it takes to find it again after a cut.
        ([(0, BEST_EFFORT)], every(0.2, UNCONFIRMED - PERIOD), UNCONFIRMED, False),
        # A listener that is lost and not found again: no zeros into nothing, and a line.
        ([(0, LATE), (19, GONE)], every(0.2, 18.8), LIMIT, True),
        ([(0, GONE)], [], LIMIT, True),
        # A listener that is lost and found again gets a burst, whatever it seems to have confirmed at first.
        ([(0, GONE), (31, RELIABLE)], every(31, 31 + LATER - PERIOD), 32, False),
        ([(0, BEST_EFFORT), (20, GONE), (40, BEST_EFFORT)], every(0.2, 19.8) + every(40, 40.8), 41, False),
        # Another node has begun to publish: somebody else moves the robot.
        ([(0, BEST_EFFORT), (4, replace(BEST_EFFORT, others=TELEOP))], every(0.2, 3.8), 4, False),
        ([(0, GONE), (31, replace(RELIABLE, others=TELEOP))], [], 31, False),
        # A node that has always published proves nothing about this stop, but may move a robot that comes back.
        ([(0, replace(LATE, others=TELEOP)), (1, replace(RELIABLE, others=TELEOP))], every(0.2, 0.8), 1, False),
        ([(0, replace(GONE, others=TELEOP)), (31, replace(RELIABLE, others=TELEOP))], [], 31, False),
        # Two listened, and one is lost: the other has received the zero, which does not help the first.
        ([(0, replace(LATE, listeners=2)), (1, RELIABLE)], every(0.2, 0.8), LIMIT, True),
        # The link was cut for so long that a first confirmation may be about earlier messages: another one is needed.
        ([(0, LATE), (OVERDUE + 1, RELIABLE)], every(0.2, OVERDUE + 2 - PERIOD), OVERDUE + 2, False),
    ],
)
def test_zeros_are_pending_until_they_are_confirmed(
    facts: list[tuple[float, TopicFacts]], sent: list[float], paid: float, told: bool
) -> None:
    assert story(*facts) == (sent, paid, told)


@pytest.mark.parametrize(
    ("facts", "asked"),
    [
        ([(0, RELIABLE)], []),
        ([(0, LATE), (1.3, RELIABLE)], [0.2]),
        ([(0, LATE), (1, replace(LATE, listeners=2)), (2, replace(RELIABLE, listeners=2))], [0.2, 1.0]),
        ([(0, LATE), (19, GONE), (31, RELIABLE)], [0.2, 31.0, 32.0]),
        ([(0, LATE), (OVERDUE + 1, RELIABLE)], [0.2, OVERDUE + 1]),
    ],
)
def test_listeners_are_asked_to_confirm_once_and_again_after_others_came_or_a_cut(
    facts: list[tuple[float, TopicFacts]], asked: list[float]
) -> None:
    found, times = FollowUp(pending_zero(0.0, 1, listened=True)), list[float]()
    while found.pending:
        now = round(found.pending.due, 6)
        found = check(found.pending, now, [each for at, each in facts if at <= now][-1])
        times += [now] * found.asks
    assert times == asked


def test_a_robot_that_never_listened_is_not_reported() -> None:
    assert story((0, GONE), listened=False) == ([], LIMIT, False)


def test_a_robot_that_an_earlier_stage_moved() -> None:
    """The listener may now be a monitor and the robot away: any new listener gets zeros, and there is no alarm."""
    assert story((0.0, RELIABLE), inherited=True) == ([], LIMIT, False)
    sent, end, tells = story((0.0, RELIABLE), (9.0, replace(RELIABLE, listeners=2)), inherited=True)
    assert sent == every(9.0, 9.0 + LATER - PERIOD)
    assert (end, tells) == (LIMIT, False)
    assert story((0.0, RELIABLE), (9.0, GONE), inherited=True)[1:] == (LIMIT, True)
    assert story((0.0, RELIABLE), (9.0, replace(RELIABLE, others=TELEOP)), inherited=True)[1:] == (9.0, False)
