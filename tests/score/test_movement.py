"""The laws of movements, compared with an independent sampling of velocities."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import partial
from hashlib import blake2b
from itertools import accumulate

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.score import algebra
from improv_core.score.dice import Chance, Choose, Seed, Shuffle, Throwing, chance, choose, seed, shuffle
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, SAME, STILL, Exact, Factors, Movement, Velocity, all_by
from improv_core.score.profiles import TURTLESIM
from improv_core.score.ramps import Ramp, Stepped, ease, ramp
from improv_core.score.score import Part, Score
from improv_core.score.walk import walk

NOTHING = algebra.series(())
SAGITTAL = Factors(SAME.x, -SAME.y, SAME.z, -SAME.yaw)
factors = st.fractions(min_value=Fraction(1, 4), max_value=4, max_denominator=4)


def velocity_at(movement: Movement, beat: Fraction, stream: str = "0", throw: int = 0) -> Velocity:
    """Compute V(t) from the definitions of the language: no walk, no merging, dice by the text of their streams."""
    within = partial(velocity_at, stream=stream, throw=throw)
    if isinstance(movement, algebra.Hold):
        return movement.velocity
    if isinstance(movement, algebra.Series):
        reached = accumulate(map(throws, movement.items), initial=throw)
        return _in_turn(movement.items, [(stream, each) for each in reached], beat)
    if isinstance(movement, algebra.Parallel):
        voices = [
            velocity_at(voice, beat, *((f"{stream}/{throw}.{index}", 0) if has_dice(movement) else (stream, throw)))
            for index, voice in enumerate(movement.items)
            if voice.duration
        ]
        return Velocity(*(sum(values, Fraction(0)) for values in zip(*voices, strict=True)))
    if isinstance(movement, algebra.Repeat):
        turn, inside = (
            (0, beat) if movement.body.duration == ENDLESS else divmod(beat, Fraction(movement.body.duration))
        )
        if movement.times is None and has_dice(movement):
            return velocity_at(movement.body, inside, f"{stream}/{throw}.0", turn * throws(movement.body))
        return velocity_at(movement.body, inside, stream, throw + turn * throws(movement.body))
    if isinstance(movement, algebra.Pace):
        return _times(within(movement.body, beat * movement.rate), movement.rate)
    if isinstance(movement, algebra.Gain):
        body = within(movement.body, beat)
        return Velocity(*(value * factor for value, factor in zip(body, movement.gain, strict=True)))
    if isinstance(movement, algebra.Reverse):
        # Reversed time turns each half-open piece around; a little before the mirrored beat is inside the right one.
        return within(movement.body, Fraction(movement.duration) - beat - Fraction(1, 10**9))
    if isinstance(movement, algebra.FromStatement):
        return within(movement.body, beat)
    if isinstance(movement, Stepped):
        played = Fraction(0)
        for lasts, rate in steps_of(movement):
            if beat < lasts:
                return _times(within(movement.body, played + beat * rate), rate)
            beat, played = beat - lasts, played + lasts * rate
    if isinstance(movement, Choose):
        chosen = thrown(stream, str(throw)) * len(movement.items) >> 64
        return velocity_at(movement.items[chosen], beat, f"{stream}/{throw}.{chosen}", 0)
    if isinstance(movement, Shuffle):
        order = list(range(len(movement.items)))
        for last in range(len(order) - 1, 0, -1):
            other = thrown(stream, f"{throw}.{last}") * (last + 1) >> 64
            order[last], order[other] = order[other], order[last]
        places = [(f"{stream}/{throw}.{index}", 0) for index in order]
        return _in_turn([movement.items[index] for index in order], places, beat)
    if isinstance(movement, Chance):
        happens = thrown(stream, str(throw)) < movement.probability * 2**64
        return velocity_at(movement.body, beat, f"{stream}/{throw}.0", 0) if happens else STILL
    if isinstance(movement, Seed):
        return velocity_at(movement.body, beat, str(movement.number), 0)
    if isinstance(movement, Throwing):
        return velocity_at(movement.body, beat, "0", movement.throw)
    raise AssertionError(movement)


def _in_turn(items: Sequence[Movement], places: Sequence[tuple[str, int]], beat: Fraction) -> Velocity:
    for item, place in zip(items, places, strict=False):
        if beat < item.duration:
            return velocity_at(item, beat, *place)
        beat -= Fraction(item.duration)
    raise AssertionError("beyond the end")


def _times(velocity: Velocity, rate: Fraction) -> Velocity:
    return Velocity(*(value * rate for value in velocity))


def thrown(stream: str, key: str) -> int:
    return int.from_bytes(blake2b(f"{stream}:{key}".encode(), digest_size=8).digest(), "big")


def has_dice(movement: Movement) -> bool:
    return isinstance(movement, (Choose, Shuffle, Chance, Seed)) or any(map(has_dice, movement.parts))


def throws(movement: Movement) -> int:
    """th(m), by the table of the language."""
    if isinstance(movement, (Choose, Shuffle, Chance)):
        return 1
    if isinstance(movement, Seed) or not has_dice(movement):
        return 0
    if isinstance(movement, algebra.Parallel) or (isinstance(movement, algebra.Repeat) and movement.times is None):
        return 1
    times = (movement.times or 0) if isinstance(movement, algebra.Repeat) else 1
    return times * sum(map(throws, movement.parts))


def steps_of(movement: Stepped) -> Iterator[tuple[Fraction, Fraction]]:
    """The steps of `ramp a b m` and `ease m`, with their rates."""
    body = Fraction(movement.body.duration)
    if isinstance(movement, Ramp):
        start, end = movement.start, movement.end
        lasts = 2 * body / (start + end)
        steps = max(1, math.ceil(8 * lasts))
        for step in range(steps):
            yield lasts / steps, start + (end - start) * Fraction(2 * step + 1, 2 * steps)
    else:
        steps = max(1, math.ceil(2 * body))
        rising = [(body / 4 / steps, Fraction(4, 3) * Fraction(2 * step + 1, 2 * steps)) for step in range(steps)]
        yield from [*rising, (body / 2, Fraction(4, 3)), *reversed(rising)]


def beats(movement: Movement) -> list[Fraction]:
    """20 beats within the first 12 of a movement, none of them on a likely breakpoint."""
    end = Fraction(min(movement.duration, 12))
    return [end * Fraction(2 * step + 1, 42) + Fraction(1, 10**7) for step in range(20)] if end else []


def sampled(movement: Movement) -> list[Velocity]:
    return [velocity_at(movement, beat) for beat in beats(movement)]


def walked(movement: Movement, *, merge: bool = False) -> list[Velocity]:
    moments = walk(movement, merge=merge)
    velocities = []
    moment = next(moments, None)
    for beat in beats(movement):
        while moment and moment.start + moment.duration <= beat:
            moment = next(moments)
        assert moment
        velocities.append(moment.velocity)
    return velocities


def holds() -> st.SearchStrategy[Movement]:
    steps = st.integers(-2, 2).map(Fraction)
    return st.builds(lambda x, y, yaw: algebra.hold(Velocity(x, y, Fraction(0), yaw)), steps, steps, steps)


def combined(inner: st.SearchStrategy[Movement], endless: bool, dice: bool = False) -> st.SearchStrategy[Movement]:
    finite = inner.filter(lambda movement: movement.duration != ENDLESS)
    several = st.lists(inner, max_size=3)
    return st.one_of(
        several.map(algebra.series),
        several.map(algebra.parallel),
        st.builds(algebra.repeat, inner, st.integers(0, 3)),
        *([inner.map(algebra.repeat)] if endless else []),
        st.builds(algebra.pace, inner, factors),
        st.builds(algebra.gain, inner, st.just(SAGITTAL) | factors.map(all_by)),
        finite.map(algebra.reverse),
        several.map(algebra.accumulate),
        st.builds(algebra.fit, finite, factors),
        st.builds(ramp, finite, rates, factors),
        st.builds(ramp, finite, factors, rates),
        finite.map(ease),
        *(
            [
                several.map(shuffle),
                st.lists(finite, max_size=3).map(chosen_of),
                st.builds(chance, inner, st.fractions(Fraction(1, 4), 1, max_denominator=4)),
                st.builds(seed, inner, factors),
            ]
            if dice
            else []
        ),
    )


rates = st.just(Fraction(0)) | factors


def chosen_of(items: list[Movement]) -> Movement:
    """Choose one of the items, all of which become as long as the first that is not empty."""
    lasting = [item for item in items if item.duration]
    return choose([algebra.fit(item, Fraction(lasting[0].duration)) for item in lasting])


finite_movements = st.recursive(holds(), lambda inner: combined(inner, False), max_leaves=8)
movements = st.recursive(holds(), lambda inner: combined(inner, True), max_leaves=8)
finite_dances = st.recursive(holds(), lambda inner: combined(inner, False, True), max_leaves=8)
dances = st.recursive(holds(), lambda inner: combined(inner, True, True), max_leaves=8)
"""Movements with dice."""


def part_of(movement: Movement) -> Part:
    return Part("r", (movement,), TURTLESIM, Pose(1, 2, 0, 0.5), "/r/cmd_vel")


def score_of(movement: Movement) -> Score:
    return Score(Fraction(60), {"r": part_of(movement)})


def same(one: Movement, other: Movement) -> bool:
    return one.duration == other.duration and sampled(one) == sampled(other)


@given(movements | dances)
def test_walk_has_the_velocities_of_the_definition(movement: Movement) -> None:
    assert walked(movement) == sampled(movement)
    assert walked(movement, merge=True) == sampled(movement)


@given(finite_movements | finite_dances, st.booleans())
def test_walk_is_as_long_as_the_movement_and_has_no_gaps(movement: Movement, evenly: bool) -> None:
    end = Fraction(0)
    for moment in walk(movement, evenly=evenly):
        assert moment.start == end
        assert moment.duration > 0
        end += moment.duration
    assert end == movement.duration


@given(movements | dances, st.fractions(0, 12, max_denominator=8))
def test_walk_may_start_anywhere(movement: Movement, start: Fraction) -> None:
    if start >= movement.duration:
        assert list(walk(movement, Fraction(min(start, movement.duration)))) == []
    else:
        first = next(walk(movement, start))
        assert first.start == start
        assert first.velocity == velocity_at(movement, start + Fraction(1, 10**8))


@pytest.mark.slow("tries many movements")
@given(movements, movements, movements)
def test_series_and_parallel_are_associative(a: Movement, b: Movement, c: Movement) -> None:
    for together in (algebra.series, algebra.parallel):
        assert same(together([together([a, b]), c]), together([a, together([b, c])]))


@pytest.mark.slow("tries many movements")
@given(movements)
def test_the_empty_movement_is_an_identity(m: Movement) -> None:
    for together in (algebra.series, algebra.parallel):
        assert same(together([m, NOTHING]), m)
        assert same(together([NOTHING, m]), m)


@pytest.mark.slow("tries many movements")
@given(finite_movements)
def test_reverse_and_retrograde_undo_themselves(m: Movement) -> None:
    assert same(algebra.reverse(algebra.reverse(m)), m)
    back = all_by(Fraction(-1))
    assert same(algebra.gain(algebra.reverse(algebra.gain(algebra.reverse(m), back)), back), m)


@given(movements, factors)
def test_pace_keeps_the_path(m: Movement, rate: Fraction) -> None:
    fast = algebra.pace(m, rate)
    assert fast.duration == (m.duration / rate if m.duration != ENDLESS else ENDLESS)
    assert same(algebra.pace(fast, 1 / rate), m)


@given(movements)
def test_reflections_and_scale_multiply_velocities(m: Movement) -> None:
    mirrored = algebra.gain(m, SAGITTAL)
    assert mirrored.duration == m.duration
    assert sampled(mirrored) == [Velocity(v.x, -v.y, v.z, -v.yaw) for v in sampled(m)]
    assert same(algebra.gain(mirrored, SAGITTAL), m)


@given(finite_movements | finite_dances, st.integers(0, 4))
def test_repeat_is_as_often_written_out(m: Movement, times: int) -> None:
    assert same(algebra.repeat(m, times), algebra.series([m] * times))


@given(st.lists(finite_movements, min_size=1, max_size=4))
def test_a_bracket_plays_each_item_as_many_times_as_fast(items: list[Movement]) -> None:
    squeezed = algebra.pace(algebra.series(items), Fraction(len(items)))
    assert same(squeezed, algebra.series([algebra.pace(item, Fraction(len(items))) for item in items]))
    assert squeezed.duration == sum((Fraction(item.duration) for item in items), Fraction(0)) / len(items)


@pytest.mark.slow("tries many movements")
@given(finite_movements)
def test_retrograde_leads_back_and_repeat_forever_is_repeat(m: Movement) -> None:
    there_and_back = algebra.series([m, algebra.gain(algebra.reverse(m), all_by(Fraction(-1)))])
    net = [
        sum((moment.velocity[axis] * moment.duration for moment in walk(there_and_back)), Fraction(0))
        for axis in range(4)
    ]
    assert net == [0, 0, 0, 0]
    if m.duration:
        assert same(
            algebra.parallel([algebra.repeat(m), algebra.repeat(m, 3)]),
            algebra.gain(algebra.repeat(m, 3), all_by(Fraction(2))),
        )


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("retrograde (forward right left)", "right left backward"),
        ("reverse (forward right left)", "left right forward"),
        ("reflect YZ right", "left"),
        ("reflect XZ forward", "backward"),
        ("reflect XY up", "down"),
        ("left || right", "rest"),
        ("(forward right) || forward", "scale 2 forward"),
        ("reverse (forward left || right)", "forward || right"),
        ("[a b || c]", "[a b] || [c]"),
        ("fast 3/2 (forward left)", "(fast 3/2 forward) fast 3/2 left"),
        ("[forward left right]", "fast 3 (forward left right)"),
        ("slow 2 fast 2 forward", "forward"),
        ("repeat 2 reverse (forward left)", "left forward left forward"),
        ("reverse forward left", "(reverse forward) left"),
        ("forward () left", "forward left"),
        ("forward || ()", "forward"),
    ],
)
def test_equivalent_movements_are_the_same(one: str, other: str) -> None:
    text = f"a = forward left\nb = slow 3/2 right\nc = halfleft up\nr1 $ {one}\nr2 $ {other}\n"
    robots = analyze(text).robots
    assert _segments(robots["r1"]) == _segments(robots["r2"])


def _segments(movement: Movement) -> list[tuple[Exact, Velocity]]:
    """Durations and velocities, with equal neighbors merged."""
    merged: list[tuple[Exact, Velocity]] = []
    for moment in walk(movement):
        if merged and merged[-1][1] == moment.velocity:
            merged[-1] = (merged[-1][0] + moment.duration, moment.velocity)
        else:
            merged.append((moment.duration, moment.velocity))
    return merged


def test_durations_are_computed_not_expanded() -> None:
    million = "1000000000"
    analysis = analyze(f"x = repeat {million} (repeat {million} (forward left))\nr $ x\nr2 $ reverse x")
    assert analysis.robots["r"].duration == 2 * 10**18
    assert next(walk(analysis.robots["r2"])).velocity.yaw == 1
    halfway = next(walk(analysis.robots["r"], Fraction(10**18 + 1)))
    assert halfway.velocity.yaw == 1


def test_long_chains_of_names_need_no_recursion() -> None:
    analysis = analyze("x = forward\n" + "x = x left\n" * 2000 + "r $ x")
    assert analysis.ok
    assert sum(1 for _ in walk(analysis.robots["r"])) == 2001


def test_moments_know_the_words_they_come_from() -> None:
    text = "x = forward left\nr $ x || rest rest"
    analysis = analyze(text)
    offsets = dict(zip(analysis.statement_ids, analysis.offsets, strict=True))
    words = [
        [text[slice(*span.shifted(offsets[statement]))] for statement, span in moment.sources]
        for moment in walk(analysis.robots["r"])
    ]
    assert words == [["x", "forward", "rest"], ["x", "left", "rest"]]
