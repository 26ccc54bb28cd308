"""The near end's knowledge about the clock there, and its questions, on a clock that the tests advance."""

from __future__ import annotations

import pytest

from improv_core.hosts.clock_queries import (
    AT_FIRST,
    MOVING,
    OFTEN,
    RESTING,
    Asking,
    answered,
    asked,
    estimated,
    lag,
    period,
    translation,
)
from improv_core.hosts.frames import RemoteTimes
from improv_core.hosts.time_translation import SECOND

AHEAD = 100.0
ASLEEP = 7.0


def exchanged(seconds: float, way: float = 0.001) -> Asking:
    """Return the state after this many seconds of questions, each of which takes `way` to get there."""
    asking = Asking(0.0)
    for number in range(int(seconds / OFTEN)):
        now = number * OFTEN
        asking = asked(asking, number, now)
        at = round((now + way + AHEAD) * SECOND)
        answer = RemoteTimes(number, at, at, wall=at + 50 * SECOND, asleep=round(ASLEEP * SECOND))
        asking = estimated(answered(asking, answer, now + 2 * way), now + 2 * way)
    return asking


@pytest.mark.parametrize(
    ("now", "moves", "seconds"),
    [(0.0, False, OFTEN), (AT_FIRST - 1, True, OFTEN), (AT_FIRST, True, MOVING), (AT_FIRST, False, RESTING)],
)
def test_it_asks_often_at_first_and_rarely_while_nothing_moves(now: float, moves: bool, seconds: float) -> None:
    assert period(Asking(0.0), now, moves=moves) == seconds


def test_the_clock_there_is_known_after_a_few_answers() -> None:
    assert exchanged(0.5).clock is None
    known = exchanged(5)
    assert known.clock
    assert known.found
    assert known.clock.remote(10.0) == pytest.approx(10.0 + AHEAD, abs=1e-6)
    assert known.found.round_trip == pytest.approx(0.002, abs=1e-6)


def test_an_answer_without_a_question_is_ignored() -> None:
    known = exchanged(5)
    liar = RemoteTimes(12_345, 0, 0, 0, 0)
    assert answered(known, liar, 6.0) == known
    again = RemoteTimes(3, 0, 0, 0, 0)  # was answered
    assert answered(known, again, 6.0) == known


def test_a_message_nearly_always_arrives_within_the_longest_way_of_the_latest_questions() -> None:
    known = exchanged(5, way=0.02)
    assert lag(known) == pytest.approx(0.02, abs=1e-6)
    lost = asked(known, 1_000, 5.0)
    at = round((5.3 + AHEAD) * SECOND)  # it was lost, and sent again
    assert lag(answered(lost, RemoteTimes(1_000, at, at, 0, 0), 5.32)) == pytest.approx(0.3, abs=1e-3)
    assert lag(Asking(0.0)) == 0.0


def test_the_border_has_both_walls_and_how_much_longer_the_machine_there_slept() -> None:
    known = translation(exchanged(5), now=5 * SECOND, wall=1_000 * SECOND, asleep=3.0)
    assert known
    assert (known.lead, known.remote_lead, known.asleep) == (995 * SECOND, 50 * SECOND, ASLEEP - 3.0)
    assert translation(Asking(0.0), now=0, wall=0, asleep=0.0) is None
