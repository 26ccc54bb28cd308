"""Movements of body parts: projections are movements like any other."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.score.algebra import gain, hold, parallel, repeat, reverse, series, stand
from improv_core.score.body import Body
from improv_core.score.by_part import by_part
from improv_core.score.equality import same
from improv_core.score.joints import Limb
from improv_core.score.movement import STILL, Factors, Movement, Velocity
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.profiles import PUPPET
from improv_core.score.projection import BASE, project
from improv_core.score.walk import walk
from tests.score.test_movement import finite_movements

assert PUPPET.body
BODY: Body = PUPPET.body
PARTS = ["head", "left_arm", "right_arm", "arms"]
YZ = Factors(1, -1, 1, -1)
WORDS = st.sampled_from([hold(velocity) for velocity in PRIMITIVES.values()])


def with_parts(inner: st.SearchStrategy[Movement]) -> st.SearchStrategy[Movement]:
    several = st.lists(inner, min_size=1, max_size=3)
    return (
        st.builds(by_part, inner, st.sampled_from(PARTS))
        | st.builds(series, several)
        | st.builds(parallel, several)
        | st.builds(reverse, inner)
        | st.builds(repeat, inner, st.integers(0, 3))
        | st.builds(lambda body: gain(body, YZ), inner)
    )


dances = st.recursive(WORDS, with_parts, max_leaves=8)
parts = st.sampled_from([each.name for each in BODY.parts])


def limb(part: str) -> Limb:
    return Limb(BODY.part[part], BODY, Fraction(60))


def performed(movement: Movement, part: str) -> list[tuple[Fraction | int, Velocity]]:
    """The beats at which the velocity of a part, or the base, changes, and its new values."""
    found: list[tuple[Fraction | int, Velocity]] = []
    for moment in walk(project(movement, part, BODY, limb("head" if part == BASE else part))):
        if not found or found[-1][1] != moment.velocity:
            found.append((moment.start, moment.velocity))
    return found


def without_parts(movement: Movement) -> Movement:
    """The movement with rests in place of the words for parts and their movements."""
    if movement.NAME == "by_part":
        assert not isinstance(movement.duration, float)
        return stand(movement.duration)
    return movement.made_of([without_parts(each) for each in movement.parts]) if movement.parts else movement


@given(finite_movements, parts)
def test_a_part_that_is_not_named_rests_as_long_as_the_movement_lasts(movement: Movement, part: str) -> None:
    found = project(movement, part, BODY, limb(part))
    assert found.duration == movement.duration
    assert all(moment.velocity == STILL for moment in walk(found))


@given(dances)
def test_the_base_plays_as_if_words_for_parts_were_rests(movement: Movement) -> None:
    def changes(each: Movement) -> list[tuple[Fraction | int, Velocity]]:
        return performed(each, BASE)

    assert changes(movement) == changes(without_parts(movement))
    assert [m.velocity for m in walk(movement) if m.velocity != STILL] == [
        m.velocity for m in walk(without_parts(movement)) if m.velocity != STILL
    ]


@given(dances, parts)
def test_every_projection_lasts_as_long(movement: Movement, part: str) -> None:
    assert project(movement, part, BODY, limb(part)).duration == movement.duration


@given(dances, parts)
def test_two_reflections_change_nothing_for_parts(movement: Movement, part: str) -> None:
    assert performed(gain(gain(movement, YZ), YZ), part) == performed(movement, part)


@given(dances)
def test_a_reflection_exchanges_the_arms_and_negates_left(movement: Movement) -> None:
    mirrored = [(beat, velocity.times(YZ)) for beat, velocity in performed(movement, "left_arm")]
    assert performed(gain(movement, YZ), "right_arm") == mirrored


def test_movements_without_words_for_parts_are_shared() -> None:
    turns = repeat(hold(PRIMITIVES["left"]), 1_000_000)
    head = by_part(turns, "head")
    assert project(series([head, turns]), "head", BODY, limb("head")).parts[0] is turns
    assert project(series([head, turns]), BASE, BODY, limb("head")).parts[1] is turns


LEFT, UP = hold(PRIMITIVES["left"]), hold(PRIMITIVES["up"])


@pytest.mark.parametrize(
    ("movement", "means"),
    [
        (lambda: by_part(by_part(LEFT, "head"), "arms"), lambda: by_part(LEFT, "head")),
        (
            lambda: gain(by_part(UP, "left_arm"), YZ),
            lambda: by_part(UP, "right_arm"),
        ),
        (lambda: by_part(gain(UP, YZ), "left_arm"), lambda: by_part(UP, "left_arm")),
    ],
)
def test_the_innermost_part_performs(movement: Callable[[], Movement], means: Callable[[], Movement]) -> None:
    for part in BODY.part:
        assert performed(movement(), part) == performed(means(), part)


def test_equal_parts_are_the_same() -> None:
    assert same(by_part(LEFT, "head"), by_part(LEFT, "head"))
    assert not same(by_part(LEFT, "head"), by_part(LEFT, "arms"))
    assert not same(by_part(LEFT, "head"), LEFT)
