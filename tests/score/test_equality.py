"""Movements that are the same apart from where they are written."""

from __future__ import annotations

import json
from fractions import Fraction

import pytest
from hypothesis import given

from improv_core.program.analysis import analyze
from improv_core.score import algebra
from improv_core.score.dice import choose, seed, shuffle
from improv_core.score.equality import same
from improv_core.score.movement import Movement
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.ramps import ease, ramp
from improv_core.score.score_json import from_json, to_json
from improv_core.score.walk import walk
from improv_core.text import Span
from tests.score.test_movement import dances, score_of

FORWARD, LEFT = (algebra.hold(PRIMITIVES[word]) for word in ("forward", "left"))


def part(program: str) -> Movement:
    return analyze(program).robots["r"]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("r $ forward left", "# A comment.\nr $ (forward\tleft)"),
        ("r $ forward left", "x = forward\n\nr $ x left"),
        ("x = left\ny = x x\nr $ y reverse y", "r $ (left left) reverse (left left)"),
        ("r $ repeat 3 (forward [left right])", "y = [left right]\nr $ repeat 3 (forward y)"),
        ("r $ fast 2 forward || left", "r $ (fast 2 forward) || left"),
        ("r $ fast 2 repeat forward || left", "r $ fast 4/2 repeat forward || left"),
    ],
)
def test_places_and_names_do_not_matter(one: str, other: str) -> None:
    assert same(part(one), part(other))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("r $ forward", "r $ left"),
        ("r $ forward left", "r $ left forward"),
        ("r $ repeat forward", "r $ repeat 4 forward"),
        ("r $ scale 2 forward", "r $ scale 3 forward"),
        ("r $ reverse (forward left)", "r $ forward left"),
        ("r $ fast 2 forward", "r $ scale 2 forward"),
        ("r $ reflect sagittal left", "r $ reflect frontal left"),
        ("x = forward\nr $ x left", "x = left\nr $ x left"),
    ],
)
def test_movements_that_play_otherwise_differ(one: str, other: str) -> None:
    assert not same(part(one), part(other))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (choose((FORWARD, LEFT)), choose((LEFT, FORWARD))),
        (choose((FORWARD, LEFT)), shuffle((FORWARD, LEFT))),
        (seed(choose((FORWARD, LEFT)), Fraction(1)), seed(choose((FORWARD, LEFT)), Fraction(2))),
        (ramp(FORWARD, 1, 2), ramp(FORWARD, 2, 1)),
        (ramp(FORWARD, 1, 1), ease(FORWARD)),
        (algebra.repeat(choose(()), 2), algebra.repeat(choose(()), 3)),
    ],
)
def test_dice_and_ramps_matter(one: Movement, other: Movement) -> None:
    assert same(one, one)
    assert same(other, other)
    assert not same(one, other)


@given(dances)
def test_a_copy_is_the_same_and_plays_alike(movement: Movement) -> None:
    (copy,) = from_json(json.loads(json.dumps(to_json(score_of(movement))))).parts.values()
    assert same(copy.movement, movement)
    assert same(algebra.from_statement(movement, Span(3, 4), 5), copy.movement)
    for moment, other in zip(walk(movement), walk(copy.movement), strict=False):
        assert moment == other
        if moment.start > 12:
            break


def test_shared_movements_are_compared_once() -> None:
    """Written out, each of them would have 2 ** 300 parts."""
    one, other = FORWARD, algebra.hold(PRIMITIVES["forward"])
    for _ in range(300):
        one, other = algebra.series((one, one)), algebra.series((other, other))
    assert same(one, other)
    assert not same(one, algebra.series((other, LEFT)))


@pytest.mark.slow("makes the longest chains")
def test_long_chains_need_no_recursion() -> None:
    chain = "x = forward\n" + "x = x left\n" * 2000 + "r $ x"
    assert same(part(chain), part(f"# Moved.\n{chain}"))
    assert not same(part(chain), part(chain.replace("x left", "x right", 1)))
