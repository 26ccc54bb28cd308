"""Movements whose rate changes evenly: `ramp` and `ease`. Standard library only.

A velocity is constant between breakpoints, so a ramp is played in steps. They are computed one by one, never listed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from improv_core.score import fields
from improv_core.score.bounds import faster, words_faster
from improv_core.score.movement import (
    NORMAL,
    Around,
    Bounds,
    Duration,
    Exact,
    Movement,
    Piece,
    Piecewise,
    Single,
    Through,
    Visit,
    all_by,
    bits,
    exact,
    makes,
    require_end,
)
from improv_core.score.throws import Dice
from improv_core.values import value

STEPS_PER_BEAT = 8
"""A step lasts an eighth of a beat, or a little less."""
FASTEST_EASE = Fraction(4, 3)
"""The rate in the middle of `ease`, with which the whole lasts as long as its body."""


class Phase(NamedTuple):
    """A number of beats in which the rate changes from `start` to `end`, in equal steps.

    Each step is played at the rate that is due in its middle.
    """

    beats: Fraction
    start: Fraction
    end: Fraction
    steps: int

    def rate(self, step: int) -> Fraction:
        return self.start + (self.end - self.start) * Fraction(2 * step + 1, 2 * self.steps)

    def played(self, beats: Exact) -> Fraction:
        """Return the beats of the body that are played within the first `beats` of this phase."""
        step_beats = self.beats / self.steps
        step = min(int(beats // step_beats), self.steps - 1)
        # The rates of the first n steps add up to n * start + n² / 2N * (end - start).
        before = step_beats * (step * self.start + Fraction(step * step, 2 * self.steps) * (self.end - self.start))
        return before + (beats - step * step_beats) * self.rate(step)

    def steps_from(self, beats: Exact) -> Iterator[Step]:
        step_beats = self.beats / self.steps
        first = int(beats // step_beats)
        yield Step((first + 1) * step_beats - beats, self.rate(first))
        for step in range(first + 1, self.steps):
            yield Step(step_beats, self.rate(step))


class Step(NamedTuple):
    """A number of beats in which the rate is constant."""

    beats: Fraction
    rate: Fraction


_NO_STEP = Step(Fraction(0), NORMAL)  # after the last one, at which the body ends too


@value(frozen=True, slots=True, eq=False)
class Stepped(Single, Piecewise, Through):
    """The same path, at a rate that changes step by step."""

    phases: tuple[Phase, ...]

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        assert not isinstance(at, float)
        return Visit(self.body, at and self.played(at), backward, dice)

    def evenly(self, around: Around) -> Around:
        """Return the surroundings of the body if its rate never changes, and it plays as long."""
        rate = Fraction(self.body.duration) / Fraction(self.duration)
        return around if rate == 1 else around._replace(rate=around.rate * rate)

    def pieces(
        self, at: Duration, backward: bool, dice: Dice | None, walk: Callable[[Visit], Iterator[Piece]]
    ) -> Iterator[Piece]:
        """Yield pieces, each of which ends as soon as the body or the rate changes."""
        assert not isinstance(at, float)
        steps = self.steps_from(at, backward)
        beats, rate = next(steps)
        for left, velocity, sources in walk(self.inner(at, backward, dice)):
            while beats * rate <= left:
                yield beats, velocity.times(all_by(rate)), sources
                left -= beats * rate
                beats, rate = next(steps, _NO_STEP)
                if not left:
                    break
            else:
                yield left / rate, velocity.times(all_by(rate)), sources
                beats -= left / rate

    def played(self, beats: Exact) -> Fraction:
        """Return the beats of the body that are played within the first `beats`."""
        total = Fraction(0)
        for phase in self.phases:
            total += phase.played(min(beats, phase.beats))
            if beats <= phase.beats:
                break
            beats -= phase.beats
        return total

    def steps_from(self, beats: Exact, backward: bool) -> Iterator[Step]:
        """Yield the rest of the step that is due at `beats`, and the steps that follow, or precede it if `backward`."""
        phases: Sequence[Phase] = self.phases
        if backward:
            phases = [Phase(each.beats, each.end, each.start, each.steps) for each in reversed(phases)]
            beats = sum(each.beats for each in phases) - beats
        for phase in phases:
            if beats < phase.beats:
                yield from phase.steps_from(beats)
                beats = 0
            else:
                beats -= phase.beats


@value(frozen=True, slots=True, eq=False)
class Ramp(Stepped):
    """A movement that begins `start` times as fast and ends `end` times as fast."""

    start: Exact
    end: Exact

    NAME = "ramp"
    FIELDS = (("start", fields.NUMBER), ("end", fields.NUMBER))


@value(frozen=True, slots=True, eq=False)
class Ease(Stepped):
    """A movement that begins and ends gently."""

    NAME = "ease"


@makes(Ramp)
def ramp(body: Movement, start: Exact, end: Exact) -> Movement:
    """Return the same path, begun `start` times as fast and ended `end` times as fast.

    Raises ValueError if one of them is below 0, both are 0, or the movement is endless or open.
    """
    if start < 0 or end < 0 or start == end == 0:
        raise ValueError("the two rates of a ramp are not below 0, and not both 0")
    beats = _beats(body)
    if not beats:
        return body
    whole, phases = _stepped(body.bounds, (2 * beats / (start + end), start, end))
    return Ramp(*whole, body, phases, start, end)


@makes(Ease)
def ease(body: Movement) -> Movement:
    """Return the same path in the same time, begun and ended gently.

    Raises ValueError if the movement is endless or open.
    """
    beats = _beats(body)
    if not beats:
        return body
    end, most = beats / 4, FASTEST_EASE
    whole, phases = _stepped(body.bounds, (end, 0, most), (beats / 2, most, most), (end, most, 0))
    return Ease(*whole, body, phases)


def _beats(body: Movement) -> Fraction:
    require_end(body)
    assert not isinstance(body.duration, float)
    return Fraction(body.duration)


def _phase(beats: Fraction, start: Exact, end: Exact) -> Phase:
    steps = 1 if start == end else max(1, math.ceil(STEPS_PER_BEAT * beats))
    return Phase(beats, Fraction(start), Fraction(end), steps)


@lru_cache(maxsize=1_000)  # at each keystroke, few of a program's ramps are new
def _stepped(
    inner: Bounds, *spans: tuple[Fraction, Exact, Exact]
) -> tuple[tuple[Exact, None, Bounds], tuple[Phase, ...]]:
    """Return the duration, the uniform velocity, the bounds, and the phases of a body with these bounds. Each span has
    the beats in which its rate changes, its first rate, and its last rate."""
    phases = tuple([_phase(*span) for span in spans])
    duration = sum(phase.beats for phase in phases)
    rate = max(max(phase.rate(0), phase.rate(phase.steps - 1)) for phase in phases)
    # A breakpoint inside is a multiple of a step's beats and of its rate, and a moment's beats are divided by the rate.
    longer = max(bits(phase.beats) + 3 * bits(phase.rate(0)) + 4 * phase.steps.bit_length() for phase in phases)
    bounds = replace(
        inner,
        peak=faster(inner.peak, rate),  # its shortest item is one of the body: a step is no item
        body=words_faster(inner.body, rate),
        bits=inner.bits + longer,
        depth=inner.depth + 1,
    )
    return (exact(Fraction(duration)), None, bounds), phases
