"""The lengths of open movements."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.score.algebra import hold, pace, parallel, repeat, series
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Duration, Movement, Velocity
from improv_core.score.performance import Mover, SenseSpan, perform
from improv_core.score.reactions import Condition, if_else, pause, until

FORWARD = hold(Velocity(x=1))
NEAR, FAR, BUMP = Condition("near", True), Condition("near", False), Condition("bump", True)
MAYBE = if_else(FORWARD, series(()), NEAR)


@pytest.mark.parametrize(
    ("movement", "shortest", "longest"),
    [
        (repeat(FORWARD, 3), 3, 3),
        (until(repeat(FORWARD, 3), NEAR), 0, 3),
        (pause(repeat(FORWARD, 3), NEAR), 3, ENDLESS),
        (pause(series(()), FAR), 0, 0),
        (if_else(repeat(FORWARD, 5), repeat(FORWARD, 2), NEAR), 2, 5),
        (series([FORWARD, until(repeat(FORWARD, 3), NEAR), FORWARD]), 2, 5),
        (repeat(MAYBE, 4), 0, 4),
        (repeat(MAYBE), ENDLESS, ENDLESS),
        (pace(until(if_else(FORWARD, repeat(FORWARD, 3), BUMP), NEAR), Fraction(2)), 0, Fraction(5, 2)),
        (parallel([until(FORWARD, NEAR), repeat(FORWARD)]), 0, 1),
        (parallel([MAYBE, repeat(FORWARD, 2)]), 0, 2),
        (parallel([pause(FORWARD, NEAR), repeat(FORWARD, 2)]), 1, 2),
        (parallel([MAYBE, pause(FORWARD, BUMP)]), 0, ENDLESS),
    ],
)
def test_the_shortest_and_the_longest_length(movement: Movement, shortest: Duration, longest: Duration) -> None:
    found = lengths(movement)
    assert (found.shortest, found.longest) == (shortest, longest)


conditions = st.builds(Condition, st.sampled_from(["near", "bump"]), st.booleans())
movements = st.recursive(
    st.fractions(Fraction(1, 2), 3, max_denominator=4).map(lambda beats: hold(Velocity(x=1), beats)),
    lambda inner: st.one_of(
        st.builds(until, inner, conditions),
        st.builds(pause, inner, conditions),
        st.builds(if_else, inner, inner, conditions),
        st.builds(repeat, inner, st.integers(0, 3)),
        st.builds(pace, inner, st.fractions(Fraction(1, 2), 2, max_denominator=3)),
        st.lists(inner, max_size=3).map(series),
        st.lists(inner, min_size=1, max_size=3).map(parallel),
    ),
    max_leaves=6,
)
beats = st.fractions(0, 12, max_denominator=8)
scripts = st.lists(
    st.tuples(st.sampled_from(["near", "bump"]), beats, beats).map(
        lambda each: SenseSpan(each[0], None, each[1], each[1] + each[2])
    ),
    max_size=4,
)


@given(movements, scripts)
def test_every_performance_lasts_so_long(movement: Movement, script: list[SenseSpan]) -> None:
    found = lengths(movement)
    lasted: Duration = 0
    for *_, moment in perform([{Mover("robot"): movement}], script):
        lasted = moment.start + moment.duration
        if lasted > 200:  # pausing forever
            lasted = ENDLESS
            break
    assert found.shortest <= lasted <= found.longest
    assert found.may_be_empty or lasted
    assert movement.open or found.shortest == found.longest == movement.duration
