"""The estimate of another clock from its messages: simulated clocks, their sightings, and the results."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import pytest

from improv_core.score.peer_clock import MAX_BENT, Anchor, Estimate, bent, first_seen, jumped, sighted

Phase = Callable[[float], float]
"""The position of a simulated clock at a time, in beats."""
JITTER = 0.005
DRIFT = 1 + 200e-6
RAMP = 10.0, 40.0


def steady(tempo: float) -> Phase:
    return lambda now: now * tempo / 60 * DRIFT


def ramp(now: float) -> float:
    """From 90 to 140 beats per minute within half a minute."""
    begins, ends = RAMP
    passed = min(max(now - begins, 0.0), ends - begins)
    return (90 * now + 50 * (passed * passed / 2 / (ends - begins) + max(now - ends, 0.0))) / 60 * DRIFT


def heard(phase: Phase, until: float, every: float, since: float = 0.0, jitter: float = JITTER) -> Iterator[Anchor]:
    """The sightings of a clock, each up to `jitter` seconds early or late."""
    chance = random.Random(1)
    for count in range(math.ceil(since / every), math.ceil(until / every)):
        at = count * every
        yield Anchor(at + chance.uniform(-jitter, jitter), phase(at), 0.0, every)


def follow(sightings: Iterable[Anchor], estimate: Estimate | None = None) -> Iterator[Estimate]:
    for each in sightings:
        known = sighted(estimate, each.at, each.phase) if estimate else first_seen(each.at, each.phase)
        estimate = known
        yield known


def check(phase: Phase, sightings: Iterable[Anchor], within: float) -> None:
    """Check that after 4 s, 99 of 100 estimates are off by less than this many seconds."""
    known = [each for each in follow(sightings) if each.anchor.at >= 4]
    off = sorted(abs(each.anchor.phase - phase(each.anchor.at)) / each.anchor.rate for each in known)
    assert off[int(0.99 * len(off))] <= within, off[-1]


@pytest.mark.parametrize("every", [0.02, 0.1], ids=["as MIDI", "as a slow simulator"])
@pytest.mark.parametrize("phase", [steady(60), steady(120), ramp])
def test_a_clock_is_known_to_a_few_milliseconds(phase: Phase, every: float) -> None:
    check(phase, heard(phase, 60, every), within=0.006)


@pytest.mark.parametrize("phase", [steady(120), ramp])
def test_sightings_that_were_held_up_count_little(phase: Phase) -> None:
    """Every thirtieth comes 50 ms late, as on a busy machine."""
    sightings = [*heard(phase, 60, 0.02)]
    late = [replace(each, at=each.at + 0.05 * (not number % 30)) for number, each in enumerate(sightings)]
    check(phase, sorted(late, key=lambda each: each.at), within=0.006)


def test_its_rate_is_known_after_half_a_second() -> None:
    known = next(each for each in follow(heard(steady(120), 10, 1 / 48)) if each.is_known)
    assert known.anchor.at <= 0.5
    assert known.anchor.rate == pytest.approx(2, rel=0.03)


def test_after_a_silence_it_is_where_it_would_be() -> None:
    *_, before = follow(heard(steady(120), 10, 0.02))
    after = next(follow(heard(steady(120), 20, 0.02, since=11), before)).anchor
    assert after.jumps == 0
    assert after.phase == pytest.approx(2 * after.at * DRIFT, abs=2 * 2 * JITTER)


def test_a_clock_that_stood_still_has_jumped_at_once() -> None:
    *_, before = follow(heard(steady(60), 10, 0.02))
    first = next(heard(steady(60), 20, 0.02, since=11))
    after = sighted(before, first.at, first.phase - 1).anchor
    assert (after.jumps, after.phase) == (1, first.phase - 1)
    assert after.rate == before.anchor.rate


def test_a_hiccup_of_the_machine_changes_nothing() -> None:
    *_, before = follow(heard(steady(120), 10, 0.02))
    late = [Anchor(10.2 + count / 1000, 20.0 + count / 25, 0.0, 0.02) for count in range(5)]
    assert {each.anchor for each in follow(late, before)} == {before.anchor}


def test_a_jump_is_one_after_a_quarter_of_a_second_and_brings_its_tempo() -> None:
    *_, before = follow(heard(steady(120), 10, 0.02))
    *_, after = follow(heard(lambda now: 3 + 2.5 * now, 10.6, 0.02, since=10), before)
    assert after.anchor.jumps == 1
    assert after.anchor.rate == pytest.approx(2.5, rel=0.05)
    assert after.anchor.phase == pytest.approx(3 + 2.5 * after.anchor.at, abs=0.02)


def test_a_start_of_the_clock_counts_at_once() -> None:
    *_, before = follow(heard(steady(120), 10, 0.02))
    after = jumped(before, 10.0, 0.0).anchor
    assert (after.phase, after.rate, after.jumps) == (0.0, before.anchor.rate, 1)


def test_sightings_at_one_time_or_backward_give_no_rate() -> None:
    first = first_seen(1.0, 5.0)
    assert sighted(first, 1.0, 6.0) == sighted(first, 2.0, 4.0) == first


@pytest.mark.parametrize("late", [-10.0, -0.5, -0.01, 0.0, 0.01, 0.5, 10.0])
def test_we_bend_toward_it_by_a_twentieth_at_most(late: float) -> None:
    rate = bent(Anchor(0, 0, 2.0, 0.1), late)
    assert abs(rate / 2 - 1) <= MAX_BENT + 1e-12
    assert (rate > 2) == (late > 0)
    assert (rate < 2) == (late < 0)
