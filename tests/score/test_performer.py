"""Open movements in performance: the values of senses and their times decide."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import groupby

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.score.algebra import hold, pace, parallel, repeat, series
from improv_core.score.movement import ENDLESS, Exact, Movement, Velocity, all_by
from improv_core.score.performance import Mover, SenseSpan, perform
from improv_core.score.performer import Performer
from improv_core.score.performing import Decision
from improv_core.score.reactions import Condition, if_else, pause, until
from improv_core.score.walk import Moment, walk
from tests.score.test_movement import finite_dances, finite_movements

FORWARD, LEFT, REST = hold(Velocity(x=1)), hold(Velocity(yaw=1)), hold(Velocity())
NOTHING = series(())
NEAR, BUMP, FAR = Condition("near", True), Condition("bump", True), Condition("near", False)
SHORT = 12
"""The beats of an endless performance to look at."""


def near(start: str, end: str | float = ENDLESS) -> SenseSpan:
    return SenseSpan("near", None, Fraction(start), Fraction(end) if isinstance(end, str) else end)


def bump(start: str, end: str | float = ENDLESS) -> SenseSpan:
    return near(start, end)._replace(sense="bump")


def performed(movement: Movement, *script: SenseSpan) -> str:
    """The movements and the beats at which they end: `forward 2.3, rest 3`."""
    words = {FORWARD.uniform: "forward", LEFT.uniform: "left", REST.uniform: "rest"}
    parts: list[tuple[str, float]] = []
    for *_, moment in perform([{Mover("robot"): movement}], script):
        if moment.start >= SHORT:
            break
        parts.append((words.get(moment.velocity, str(moment.velocity)), float(moment.start + moment.duration)))
    runs = [(word, max(end for _, end in run)) for word, run in groupby(parts, key=lambda part: part[0])]
    return ", ".join(f"{word} {end:g}" for word, end in runs)


ROAMER = repeat(series([until(repeat(FORWARD), NEAR), LEFT]))


@pytest.mark.parametrize(
    ("movement", "script", "expected"),
    [
        (series([until(repeat(FORWARD), NEAR), LEFT]), [near("2.3")], "forward 2.3, rest 3, left 4"),
        (series([until(repeat(FORWARD), NEAR), LEFT]), [near("2")], "forward 2, rest 3, left 4"),
        (series([until(pace(FORWARD, Fraction(4)), NEAR), LEFT]), [near("0")], "rest 0.25, left 1.25"),
        (until(FORWARD, FAR), [], "rest 1"),
        (pause(repeat(FORWARD, 2), NEAR), [near("0.5", "2.25")], "forward 0.5, rest 2.5, forward 4"),
        (pause(FORWARD, NEAR), [near("1")], "forward 1"),
        (repeat(if_else(NOTHING, LEFT, NEAR)), [near("2.5", "11")], "left 3, rest 11, left 12"),
        (series([repeat(if_else(NOTHING, LEFT, NEAR), 5), FORWARD]), [near("1.5")], "left 2, forward 3"),
        (repeat(if_else(NOTHING, NOTHING, NEAR)), [], "rest 12"),
        (parallel([if_else(NOTHING, LEFT, NEAR), FORWARD]), [near("0")], "forward 1"),
        (series([parallel([until(repeat(FORWARD), NEAR), repeat(REST, 4)]), LEFT]), [near("1.3")],
         "forward 1.3, rest 2, left 3"),
        (ROAMER, [near("1.5", "2.5"), near("11", "11.6")], "forward 1.5, rest 2, left 3, forward 11, rest 12"),
        (until(series([FORWARD, if_else(NOTHING, LEFT, NEAR)]), BUMP), [near("0"), bump("1")], "forward 1, rest 2"),
        (until(until(FORWARD, NEAR), BUMP), [bump("1")], "forward 1"),
    ],
)  # fmt: skip
def test_senses_decide_the_performance(movement: Movement, script: Sequence[SenseSpan], expected: str) -> None:
    assert performed(movement, *script) == expected


@given(finite_movements | finite_dances, st.fractions(Fraction(1, 4), 2, max_denominator=4))
def test_open_movements_without_edges_play_like_closed_ones(movement: Movement, rate: Fraction) -> None:
    """Also within words of senses, and at another pace."""
    open_movement = pace(until(pause(movement, NEAR), BUMP), rate)
    moments = [moment for *_, moment in perform([{Mover("robot"): open_movement}], [])]
    assert sum(moment.duration for moment in moments) == pace(movement, rate).duration
    assert distance(moments) == distance(list(walk(movement)))


def distance(moments: Sequence[Moment]) -> Velocity:
    total = Velocity()
    for moment in moments:
        total = total.plus(moment.velocity.times(all_by(moment.duration)))
    return total


@given(st.lists(st.fractions(0, 10, max_denominator=8), max_size=12))
def test_looking_more_often_changes_nothing(beats: list[Fraction]) -> None:
    """A player settles whenever anything happens, at any beat."""
    sensing = near("2.25", "4.75")
    often = [near(f"{beat}", f"{beat}")._replace(sense="other") for beat in beats]
    assert performed(ROAMER, sensing, *often) == performed(ROAMER, sensing)


@given(finite_movements | finite_dances, st.booleans())
def test_looking_ahead_changes_nothing(movement: Movement, forks: bool) -> None:
    """Also for a performance that continues by itself from there."""

    def moments(foresees: bool) -> list[tuple[Exact, Velocity]]:
        performer = Performer(movement)
        found: list[tuple[Exact, Velocity]] = []
        while not performer.is_over and len(found) < SHORT:
            if foresees:
                performer.foresee()
                performer.foresee()
                performer = performer.fork() if forks else performer
            assert not isinstance(performer.until, float)
            found.append((performer.until, performer.performed(lambda sense: None)[0]))
            performer.advance(performer.until)
        return found

    assert moments(True) == moments(False)


def test_decisions_are_reported() -> None:
    performer = Performer(series([until(repeat(FORWARD), NEAR), if_else(LEFT, REST, NEAR)]))
    sensed: Callable[[str], bool] = lambda sense: False  # noqa: E731
    assert performer.settle(sensed) == []
    assert performer.watched() == {"near"}
    performer.advance(Fraction(1, 2))
    assert performer.settle(lambda sense: True) == [Decision((), Fraction(1, 2), True)]
    assert performer.until == 1
    assert performer.watched() == set()
    performer.advance(1)
    assert performer.settle(sensed) == [Decision((), 1, False)]


def test_a_billion_rounds_begin_at_once() -> None:
    beat: Exact = 0
    performer = Performer(repeat(until(repeat(FORWARD, 10**9), NEAR), 10**9), beat)
    performer.settle(lambda sense: False)
    assert performer.until == 1
