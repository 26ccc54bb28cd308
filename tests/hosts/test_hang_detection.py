"""The limits after which a stage beside the far end of a link counts as hung, on a clock that the tests advance."""

from __future__ import annotations

import pytest

from improv_core.hosts.hang_detection import (
    HARMLESS_LIMIT,
    Unanswered,
    answered,
    loading,
    looked,
    pinged,
    plays,
    ready,
    stopped,
)
from improv_core.protocol.limits import END_LIMIT, HANG_LIMIT, LOADING_LIMIT

PERIOD = 0.05


class Turned:
    def __init__(self, *, moves: bool = True) -> None:
        self.now = 0.0
        self.asked = ready(Unanswered(looked=0.0), 0.0)
        self.asked = plays(self.asked, moves)

    def exceeds(self, seconds: float) -> float | None:
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            self.asked, limit = looked(self.asked, self.now, PERIOD)
            if limit:
                return limit
        return None

    def ping(self, number: int, *, behind_score: bool = False) -> None:
        self.asked = pinged(self.asked, number, self.now, behind_score=behind_score)


@pytest.mark.parametrize(("moves", "limit"), [(True, HANG_LIMIT), (False, HARMLESS_LIMIT)])
def test_a_stage_that_does_not_answer_hangs(moves: bool, limit: float) -> None:
    turned = Turned(moves=moves)
    turned.ping(1)
    assert turned.exceeds(limit - PERIOD) is None
    assert turned.exceeds(3 * PERIOD) == limit


def test_later_answers_do_not_hide_one_that_is_missing() -> None:
    turned = Turned()
    turned.ping(1)
    turned.ping(2)
    turned.asked = answered(turned.asked, 2, turned.now)
    assert turned.exceeds(HANG_LIMIT + 2 * PERIOD) == HANG_LIMIT


def test_before_it_is_ready_it_may_take_as_long_as_its_parent_allows() -> None:
    turned = Turned()
    turned.asked = plays(Unanswered(looked=0.0), True)
    turned.ping(1)
    assert turned.exceeds(60) is None
    turned.asked = ready(turned.asked, turned.now)
    assert turned.exceeds(HANG_LIMIT + 2 * PERIOD) == HANG_LIMIT


def test_a_score_may_take_long_until_the_ping_behind_it_is_answered() -> None:
    turned = Turned()
    turned.asked = loading(turned.asked)
    turned.ping(7, behind_score=True)
    turned.ping(8)
    assert turned.exceeds(LOADING_LIMIT - PERIOD) is None
    turned.asked = answered(turned.asked, 7, turned.now)
    assert turned.exceeds(HANG_LIMIT - PERIOD) is None
    assert turned.exceeds(3 * PERIOD) == HANG_LIMIT


def test_a_stage_may_take_a_while_to_exit_after_its_last_message() -> None:
    turned = Turned()
    turned.ping(1)
    turned.asked = stopped(turned.asked, turned.now)
    assert turned.exceeds(END_LIMIT) is None


def test_a_late_look_proves_nothing_about_the_stage() -> None:
    turned = Turned()
    turned.ping(1)
    turned.now += 10
    assert turned.exceeds(PERIOD) is None
    assert turned.exceeds(HANG_LIMIT + 2 * PERIOD) == HANG_LIMIT
