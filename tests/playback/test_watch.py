"""When a stage counts as hung, by a clock that the tests turn."""

from __future__ import annotations

import pytest

from improv_core.playback.watch import HARMLESS_HANG_LIMIT, LOOK_PERIOD, PULSE_LIMIT, REST, Watch
from improv_core.stage.protocol import END_LIMIT, HANG_LIMIT, LOADING_LIMIT


class Turned:
    """A watch over a stage that moves real robots, whose clock is turned look by look."""

    def __init__(self, real: bool = True, plays: bool = True) -> None:
        self.now = 0.0
        self.watch = Watch(self.now)
        self.watch.moving(plays, False, self.now)
        self._real = real

    def exceeds(self, seconds: float) -> float | None:
        """The limit that the stage exceeds within so many seconds without an answer."""
        for _ in range(round(seconds / LOOK_PERIOD)):
            self.now += LOOK_PERIOD
            if limit := self.watch.look(self.now, self._real):
                return limit
        return None

    def ping(self) -> int:
        number = self.watch.ping(self.now)
        assert number
        return number

    def load(self) -> int:
        """Send a score; the number of the ping behind it."""
        self.watch.loading()
        return self.ping()


@pytest.mark.parametrize(
    ("real", "plays", "limit"),
    [(True, True, HANG_LIMIT), (True, False, HARMLESS_HANG_LIMIT), (False, True, HARMLESS_HANG_LIMIT)],
)
def test_a_stage_hangs_that_does_not_answer(real: bool, plays: bool, limit: float) -> None:
    turned = Turned(real, plays)
    assert turned.exceeds(limit - LOOK_PERIOD) is None
    turned.watch.pong(turned.ping(), turned.now)
    assert turned.exceeds(limit - LOOK_PERIOD) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == limit


def test_a_stage_may_take_its_time_over_a_score_until_it_answers_what_comes_behind_it() -> None:
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


def test_a_stage_that_has_stopped_may_take_its_time_to_end() -> None:
    turned = Turned()
    turned.watch.stopped(turned.now)
    assert turned.exceeds(END_LIMIT) is None
    assert turned.exceeds(2 * HANG_LIMIT) == HANG_LIMIT


def test_that_we_stood_still_says_nothing_about_the_stage() -> None:
    turned = Turned()
    turned.now += 100
    assert turned.exceeds(HANG_LIMIT) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == HANG_LIMIT


def test_no_pings_go_out_while_our_event_loop_hangs() -> None:
    turned = Turned()
    turned.now += PULSE_LIMIT
    assert turned.watch.ping(turned.now) == 1
    turned.now += LOOK_PERIOD
    assert turned.watch.ping(turned.now) is None
    turned.watch.look(turned.now, real=True)
    assert turned.watch.ping(turned.now) == 2


def test_a_stage_rests_that_moves_nothing_and_has_answered() -> None:
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


def test_a_stage_that_rested_is_pinged_and_not_taken_for_hung() -> None:
    turned = Turned()
    turned.watch.pong(turned.ping(), turned.now)
    turned.now += 100
    turned.watch.writing(turned.now)
    turned.ping()
    assert turned.exceeds(HANG_LIMIT) is None
    assert turned.exceeds(3 * LOOK_PERIOD) == HANG_LIMIT
