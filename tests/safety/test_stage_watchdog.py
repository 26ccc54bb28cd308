"""The limits after which a stage counts as hung, on a clock that the tests advance."""

from __future__ import annotations

import pytest

from improv_core.protocol.limits import END_LIMIT, HANG_LIMIT, LOADING_LIMIT
from improv_core.safety.heartbeat import HARMLESS_HANG_LIMIT, LOOK_PERIOD, PULSE_LIMIT, REST, StageWatchdog


class Turned:
    """A watch over a stage that moves real robots, on a clock that advances look by look."""

    def __init__(self, real: bool = True, plays: bool = True) -> None:
        self.now = 0.0
        self.watch = StageWatchdog(self.now)
        self.watch.moving(plays, False, self.now)
        self._real = real
        self._number = 0

    def exceeds(self, seconds: float) -> float | None:
        """Return the limit that the stage exceeds within this many seconds without an answer."""
        for _ in range(round(seconds / LOOK_PERIOD)):
            self.now += LOOK_PERIOD
            if limit := self.watch.look(self.now, self._real):
                return limit
        return None

    def ping(self) -> int:
        assert self.watch.may_ping(self.now)
        self.watch.ping(self.number())
        return self._number

    def number(self) -> int:
        self._number += 1
        return self._number

    def load(self) -> int:
        """Send a score; returns the number of the ping after it."""
        self.watch.loading(self.number())
        return self._number


@pytest.mark.parametrize(
    ("real", "plays", "limit"),
    [(True, True, HANG_LIMIT), (True, False, HARMLESS_HANG_LIMIT), (False, True, HARMLESS_HANG_LIMIT)],
)
def test_a_stage_that_does_not_answer_is_hung(real: bool, plays: bool, limit: float) -> None:
    turned = Turned(real, plays)
    assert turned.exceeds(limit - LOOK_PERIOD) is None
    turned.watch.pong(turned.ping(), turned.now)
    assert turned.exceeds(limit - LOOK_PERIOD) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == limit


def test_a_stage_may_take_long_over_a_score_until_it_answers_the_next_ping() -> None:
    turned = Turned()
    behind = turned.load()
    assert turned.exceeds(LOADING_LIMIT - LOOK_PERIOD) is None
    turned.watch.pong(behind, turned.now)
    assert turned.exceeds(2 * HANG_LIMIT) == HANG_LIMIT


def test_the_answer_to_one_score_does_not_end_the_time_for_the_next() -> None:
    turned = Turned()
    behind_first = turned.load()
    turned.load()
    turned.watch.pong(behind_first, turned.now)
    assert turned.exceeds(LOADING_LIMIT - LOOK_PERIOD) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == LOADING_LIMIT


def test_a_stopped_stage_may_take_long_to_end() -> None:
    turned = Turned()
    turned.watch.stopped(turned.now)
    assert turned.exceeds(END_LIMIT) is None
    assert turned.exceeds(2 * HANG_LIMIT) == HANG_LIMIT


def test_our_own_stall_proves_nothing_about_the_stage() -> None:
    turned = Turned()
    turned.now += 100
    assert turned.exceeds(HANG_LIMIT) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == HANG_LIMIT


def test_no_pings_go_out_while_our_event_loop_hangs() -> None:
    turned = Turned()
    turned.now += PULSE_LIMIT
    assert turned.watch.may_ping(turned.now)
    turned.now += LOOK_PERIOD
    assert not turned.watch.may_ping(turned.now)
    turned.watch.look(turned.now, real=True)
    assert turned.watch.may_ping(turned.now)


def test_a_stage_that_moves_nothing_and_has_answered_rests() -> None:
    turned = Turned(plays=False)
    assert not turned.watch.rests(REST)
    number = turned.ping()
    assert not turned.watch.rests(10.0)
    turned.watch.pong(number, 0.1)
    assert turned.watch.rests(10.0)
    turned.watch.writing(10.0)
    assert not turned.watch.rests(10.0 + REST)
    turned.watch.moving(False, True, 10.5)
    assert not turned.watch.rests(20.0)
    turned.watch.moving(False, False, 30.0)
    assert not turned.watch.rests(30.0 + REST)
    assert turned.watch.rests(30.1 + REST)


def test_a_stage_that_rested_is_pinged_before_it_counts_as_hung() -> None:
    turned = Turned()
    turned.watch.pong(turned.ping(), turned.now)
    turned.now += 100
    turned.watch.writing(turned.now)
    turned.ping()
    assert turned.exceeds(HANG_LIMIT) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == HANG_LIMIT
