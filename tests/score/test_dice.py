"""Dice: the throws and the movements that they decide. Expected outcomes are those of the language's reference."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from itertools import islice, pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.score import algebra
from improv_core.score.algebra import hold, pace, repeat, series
from improv_core.score.dice import chance, choose, seed, shuffle, throwing
from improv_core.score.equality import same
from improv_core.score.movement import ENDLESS, STILL, Movement, all_by
from improv_core.score.path import extent, pose_at
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.profiles import TURTLESIM
from improv_core.score.ramps import ease, ramp
from improv_core.score.score_json import from_json, to_json
from improv_core.score.throws import dice_of
from improv_core.score.walk import Moment, walk
from improv_core.text import Span
from tests.score.test_movement import (
    dances,
    finite_dances,
    part_of,
    sampled,
    score_of,
    thrown,
    throws,
    velocity_at,
)
from tests.score.test_path import walked

WORDS = {velocity: word for word, velocity in PRIMITIVES.items()}
F, B, L, R, UP, DOWN, SL, SR, HR, REST = (
    hold(PRIMITIVES[word])
    for word in ["forward", "backward", "left", "right", "up", "down", "strafeleft", "straferight", "halfright", "rest"]
)
HALF = Fraction(1, 2)
BACK = all_by(-1)


def check(movement: Movement, words: str) -> None:
    """Check the words that play, one after another, each as long as it lasts."""
    moments = islice(walk(movement), len(words.split()))
    assert " ".join(WORDS.get(moment.velocity, "both") for moment in moments) == words


@pytest.mark.parametrize(
    ("movement", "words"),
    [
        (choose([F, B, L, R]), "right"),
        (repeat(choose([F, L]), 6), "left left left forward left forward"),
        (repeat(choose([series([F, L]), series([R, REST])]), 3), "right rest right rest right rest"),
        (shuffle([F, L, R, REST, B]), "backward forward left rest right"),
        (repeat(shuffle([F, L, R]), 3), "right forward left right forward left left forward right"),
        (repeat(chance(F, Fraction(1, 3)), 8), "rest rest rest forward rest rest rest forward"),
        (
            seed(repeat(chance(F, Fraction(1, 3)), 8), Fraction(7)),
            "rest forward forward rest forward forward rest rest",
        ),
        (seed(shuffle([F, L, R]), Fraction(3, 2)), "right forward left"),
        (
            series([choose([F, L]), shuffle([F, chance(L, HALF), R]), choose([L, R])]),
            "left right forward left right",
        ),
        (algebra.reverse(series([choose([F, L]), choose([F, R]), chance(UP, HALF)])), "rest right left"),
        (
            series([algebra.parallel([repeat(choose([F, L]), 3), repeat(choose([SL, SR]), 3)]), choose([UP, DOWN])]),
            "both both both down",
        ),
        (series([throwing(choose([F, L]), 0), throwing(repeat(choose([F, L, R]), 3), 1)]), "left right right forward"),
    ],
)
def test_dice_choose_the_words_that_play(movement: Movement, words: str) -> None:
    check(movement, words)


@pytest.mark.parametrize(
    ("movement", "taken"),
    [
        (choose([F, L]), 1),
        (choose([]), 1),
        (shuffle([F, choose([L, R])]), 1),
        (chance(choose([F, L]), HALF), 1),
        (seed(choose([F, L]), Fraction(3)), 0),
        (series([choose([F, L]), R, shuffle([F])]), 2),
        (repeat(choose([F, L]), 10**30), 10**30),
        (repeat(choose([F, L])), 1),
        (repeat(choose([F, L]), 0), 0),
        (repeat(choose([]), 5), 5),
        (repeat(choose([])), 1),
        (repeat(repeat(choose([F, L])), 3), 3),
        (algebra.parallel([choose([F, L]), choose([F, L])]), 1),
        (algebra.parallel([F, repeat(choose([F, L]), 0)]), 1),
        (algebra.parallel([choose([]), choose([])]), 1),
        (algebra.parallel([F, L]), 0),
        (algebra.accumulate([choose([F, L])] * 3), 6),
        (algebra.reverse(repeat(choose([F, L]), 4)), 4),
        (algebra.fit(repeat(choose([F, L]), 4), 2), 4),
        (ease(ramp(repeat(choose([F, L]), 4), 1, 2)), 4),
    ],
)
def test_a_movement_takes_as_many_throws_as_defined(movement: Movement, taken: int) -> None:
    assert movement.bounds.throws == throws(movement) == taken


def test_a_voice_throws_by_the_place_in_which_it_is_written() -> None:
    """An empty voice plays nothing, but keeps its place, and turns its neighbor into a voice of dice."""
    nothing, turns = series(()), repeat(choose([F, L]), 9)
    with_voice = algebra.parallel([nothing, turns])
    stream = "0/0.1"
    expected = [(F, L)[thrown(stream, str(key)) * 2 >> 64] for key in range(9)]
    assert [moment.velocity for moment in walk(with_voice)] == [item.uniform for item in expected]
    assert not same(with_voice, algebra.parallel([turns, nothing]))


@given(dances)
def test_throws_are_counted_as_the_table_says(movement: Movement) -> None:
    assert movement.bounds.throws == throws(movement)


@given(finite_dances, st.fractions(1, 4, max_denominator=4))
def test_retracing_leads_back_home(movement: Movement, number: Fraction) -> None:
    there = seed(movement, number)
    there_and_back = series([there, algebra.gain(algebra.reverse(there), BACK)])
    part = part_of(there_and_back)
    home = pose_at(part, Fraction(there_and_back.duration))
    assert home
    assert (home.x, home.y, home.z, home.heading) == pytest.approx((1, 2, 0, 0.5), abs=1e-9)


@given(finite_dances)
def test_reverse_performs_the_same_throws(movement: Movement) -> None:
    forward = [(moment.duration, moment.velocity) for moment in walk(movement)]
    assert [(moment.duration, moment.velocity) for moment in walk(algebra.reverse(movement))] == forward[::-1]


@given(dances, st.lists(st.fractions(0, 12, max_denominator=24), max_size=4))
def test_a_walk_does_not_depend_on_where_it_is_split(movement: Movement, places: list[Fraction]) -> None:
    end = min(movement.duration, 12)
    whole = _until(movement, Fraction(0), Fraction(end))
    bounds = [Fraction(0), *sorted(place for place in places if place < end), Fraction(end)]
    split = [piece for start, stop in pairwise(bounds) for piece in _until(movement, start, stop)]
    assert _joined(split) == _joined(whole)


def _until(movement: Movement, start: Fraction, stop: Fraction) -> list[Moment]:
    found = []
    for moment in walk(movement, start) if start < stop else ():
        if moment.start >= stop:
            break
        found.append(moment._replace(duration=min(moment.duration, stop - moment.start)))
    return found


def _joined(moments: Sequence[Moment]) -> list[tuple[Any, Any]]:
    """The times at which the velocity changes, and its new values."""
    changes: list[tuple[Any, Any]] = []
    for moment in moments:
        if not changes or changes[-1][1] != moment.velocity:
            changes.append((moment.start, moment.velocity))
    return changes


@given(finite_dances, st.integers(0, 3), st.integers(0, 10**9))
def test_rests_before_a_movement_do_not_change_its_throws(movement: Movement, rests: int, throw: int) -> None:
    """So the robots of one line, and the voices of a canon, are in unison."""
    alone = throwing(movement, throw)
    canon = series([algebra.repeat(REST, rests), alone])
    expected = [(moment.start, moment.velocity) for moment in walk(alone)]
    assert [(moment.start - rests, moment.velocity) for moment in walk(canon, rests)] == expected


@given(finite_dances, st.fractions(Fraction(1, 3), 5, max_denominator=7))
def test_fit_lasts_exactly_so_many_beats(movement: Movement, beats: Fraction) -> None:
    fitted = algebra.fit(movement, beats)
    assert fitted.duration == (beats if movement.duration else 0)
    assert _end(fitted) == pytest.approx(_end(movement), abs=1e-9)


@given(finite_dances, st.fractions(0, 3, max_denominator=5), st.fractions(Fraction(1, 5), 3, max_denominator=5))
def test_ramp_and_ease_end_where_their_body_does(movement: Movement, start: Fraction, end: Fraction) -> None:
    assert ease(movement).duration == movement.duration
    for stepped in (ramp(movement, start, end), ramp(movement, end, start)):
        assert stepped.duration == movement.duration * 2 / (start + end)
        assert _walked_end(stepped) == pytest.approx(_walked_end(movement), abs=1e-9)
    assert _walked_end(ease(movement)) == pytest.approx(_walked_end(movement), abs=1e-9)


def _end(movement: Movement) -> tuple[float, ...]:
    pose = pose_at(part_of(movement), Fraction(movement.duration))
    assert pose
    return pose.x, pose.y, pose.z, pose.heading


def _walked_end(movement: Movement) -> tuple[float, ...]:
    """The pose at the end, computed from all moments, step by step."""
    pose = walked(part_of(movement), Fraction(movement.duration))
    return pose.x, pose.y, pose.z, pose.heading


@pytest.mark.parametrize(
    "make",
    [
        lambda: ramp(repeat(repeat(F)), 1, 2),
        lambda: ease(repeat(F)),
        lambda: algebra.fit(repeat(F), 2),
        lambda: algebra.reverse(shuffle([F, repeat(L)])),
        lambda: choose([F, series([F, F])]),
        lambda: choose([F, repeat(F)]),
        lambda: ramp(F, 0, 0),
        lambda: ramp(F, -1, 2),
        lambda: chance(F, Fraction(0)),
        lambda: chance(F, Fraction(3, 2)),
        lambda: seed(F, Fraction(0)),
    ],
)
def test_impossible_movements_are_refused(make: Any) -> None:
    with pytest.raises(ValueError, match=r" "):
        make()


def test_a_rest_that_the_dice_give_is_written_where_the_word_stands() -> None:
    never = chance(repeat(F), Fraction(1, 10**9), Span(3, 9))
    moments = list(islice(walk(algebra.from_statement(never, None, 4)), 3))
    assert [moment.velocity for moment in moments] == [STILL] * 3
    assert [[(source.statement, source.span) for source in moment.sources] for moment in moments] == [
        [(4, Span(3, 9))]
    ] * 3


def test_equal_items_are_not_merged_where_dice_decide() -> None:
    assert choose([F, F]).uniform is None
    assert len(list(walk(repeat(choose([F, F]), 3), merge=True))) == 3


def test_steps_are_no_items() -> None:
    """The shortest item of a ramp is an item of its body."""
    assert ramp(F, 1, 1).bounds.peak.shortest == 1
    assert ease(series([F, F])).bounds.peak.shortest == 0.75
    assert ease(F).bounds.peak.x == pytest.approx(4 / 3)


BILLION = 10**9
HUGE = {
    "ramp": ramp(repeat(F, 10**6), 0, 1),
    "ramps": ramp(ease(repeat(series([F, L]), 10**6)), 1, Fraction(1, 3)),
    "repeat": repeat(repeat(series([F, choose([L, R])]), BILLION), BILLION),
    "endless": repeat(series([F, chance(L, HALF)])),
    "shuffles": repeat(shuffle([F, shuffle([L, R, UP])]), BILLION),
    "voices": repeat(algebra.parallel([repeat(choose([F, L])), series([F, F])]), BILLION),
    "accumulate": algebra.accumulate([choose([F, L])] * 1000),
}
BEYOND_THE_DEFINITION = ("ramp", "ramps", "accumulate")
"""Read literally, the definition lists every step and every beginning."""


@pytest.mark.parametrize("name", HUGE)
def test_huge_movements_can_start_anywhere(name: str) -> None:
    """Each of these would take hours, or all memory, if it were expanded."""
    movement = HUGE[name]
    middle = 10**14 if movement.duration == ENDLESS else int(movement.duration // 3)
    near_end = BILLION if movement.duration == ENDLESS else int(movement.duration) - 1
    for beat in (0, middle, near_end):
        moment = next(walk(movement, beat))
        assert moment.start == beat
        if name not in BEYOND_THE_DEFINITION:
            assert moment.velocity == velocity_at(movement, beat + Fraction(1, 10**7))
    data = json.loads(json.dumps(to_json(score_of(movement))))
    assert len(data["movements"]) < 3000
    assert same(from_json(data).parts["r"].movement, movement)
    pose_at(part_of(movement), middle)
    extent(movement, TURTLESIM)


def test_after_too_many_throws_the_pose_is_unknown() -> None:
    few, many = (repeat(series([F, choose([L, R])]), times) for times in (2_000, 200_000))
    assert pose_at(part_of(few), 4_000)
    assert extent(few, TURTLESIM)
    assert pose_at(part_of(many), 400_000) is None
    assert extent(many, TURTLESIM) is None
    assert pose_at(part_of(many), 4_000) == pose_at(part_of(few), 4_000)


def test_streams_within_streams_are_named_by_all_throws_above() -> None:
    """The stream is hashed as it grows, and yields what its whole name would."""
    dice = dice_of("0").after(7).inside(2).after(10**40).inside(0).after(3)
    assert dice.choice(2**64) == thrown(f"0/7.2/{10**40}.0", "3")


DEEP = 2_000


@pytest.mark.parametrize(
    "rows",
    [
        [["choose", [0, 1]]],
        [["ramp", 0, 0, 0]],
        [["ramp", 0, "-1", 1]],
        [["ramp", 0, 1]],
        [["ramp", 0, "1" + "0" * 1500, 1]],
        [["ramp", 2, 1, 2]],
        [["ease", 2]],
        [["chance", 0, "3/2", None]],
        [["chance", 0, "1/2"]],
        [["seed", 0, 0]],
        [["throwing", 0, -1]],
        [["throwing", 0, 10**2000]],
        [["repeat", 0, 10**2000]],
        [["choose", [0]], *(["repeat", place, 10**90] for place in range(3, 53))],
        [["choose", []], *(["repeat", place, 10**90] for place in range(3, 53))],
        [["choose", [0]], *(["parallel", [place]] for place in range(3, 5)), ["shuffle", 0]],
        [["choose", [0]], *(["parallel", [place, 3]] for place in range(3, DEEP))],
        [["ease", 0], *(["ease", place] for place in range(3, DEEP))],
    ],
)
def test_rows_out_of_range_are_refused(rows: list[Any]) -> None:
    first = [["hold", [1, 0, 0, 0], 1, None], ["hold", [0, 0, 0, 1], 2, None], ["repeat", 0, None]]
    data = json.loads(json.dumps(to_json(score_of(F))))
    data["movements"], data["parts"]["r"]["scenes"] = [*first, *rows], [len(first) + len(rows) - 1]
    with pytest.raises((ValueError, TypeError, IndexError, OverflowError)):
        from_json(data)
    data["movements"], data["parts"]["r"]["scenes"] = first, [0]
    assert sampled(from_json(data).parts["r"].movement) == sampled(F)


def test_a_bracket_squeezes_dice() -> None:
    check(pace(series([choose([F, L]), choose([F, L])]), Fraction(2)), "both both")
