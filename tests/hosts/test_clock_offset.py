"""Estimates of another clock from exchanges over links whose delays the tests throw."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from operator import lt
from statistics import quantiles

import pytest

from improv_core.hosts.clock_offset import (
    SLEW,
    STEP,
    Estimated,
    Exchange,
    Exchanges,
    RemoteClock,
    estimate,
    is_known,
    noted,
    steered,
)

SHORTEST, LONGEST, LOST, AGAIN = 0.002, 0.1, 0.02, 0.2
RATE = 20
LINKS = 20
Delay = Callable[[random.Random], float]


def evenly(dice: random.Random) -> float:
    return dice.uniform(SHORTEST, LONGEST)


def mostly_short(dice: random.Random) -> float:
    return min(SHORTEST + dice.expovariate(3 / LONGEST), LONGEST)


class Pair:
    """Two clocks and the link between them: a lost message comes later, and none overtakes, as in TCP."""

    def __init__(self, seed: int, delay: Delay, drift: float | None = None) -> None:
        self.dice = random.Random(seed)
        self.delay = delay
        self.offset = self.dice.uniform(-1e5, 1e5)
        self.drift = self.dice.uniform(-100e-6, 100e-6) if drift is None else drift

    def remote(self, local: float) -> float:
        return local + self.offset + self.drift * local

    def exchanges(self, seconds: float) -> Iterator[Exchange]:
        down = up = 0.0
        for number in range(int(seconds * RATE)):
            sent = number / RATE
            down = max(sent + self._takes(), down)
            up = max(down + self._takes(), up)
            yield Exchange(sent, self.remote(down), self.remote(down), up)

    def known(self, seconds: float) -> Exchanges:
        exchanges = Exchanges()
        for each in self.exchanges(seconds):
            if each.heard <= seconds:
                exchanges = noted(exchanges, each)
        return exchanges

    def _takes(self) -> float:
        return self.delay(self.dice) + (AGAIN if self.dice.random() < LOST else 0.0)


def check(delay: Delay, bounds: Mapping[float, tuple[float, float]], drift: float | None = None) -> None:
    """Check that after this many seconds each, the offset is off by less than these milliseconds: in half of the links,
    and in 19 of 20."""
    off = dict[float, list[float]]()
    for seed in range(LINKS):
        pair, exchanges = Pair(seed, delay, drift), Exchanges()
        looks = iter(bounds)
        seconds = next(looks, math.inf)
        for each in pair.exchanges(max(bounds) + 1):
            if each.heard > seconds:
                found = estimate(exchanges, seconds)
                assert found
                off.setdefault(seconds, []).append(1000 * abs(found.offset - (pair.remote(seconds) - seconds)))
                seconds = next(looks, math.inf)
            exchanges = noted(exchanges, each)
    reached = {seconds: (cuts[9], cuts[18]) for seconds, each in off.items() for cuts in [quantiles(each, n=20)]}
    assert reached.keys() == bounds.keys()
    assert {seconds: each for seconds, each in reached.items() if not all(map(lt, each, bounds[seconds]))} == {}


@pytest.mark.parametrize(
    ("delay", "bounds"),
    [
        (mostly_short, {3: (0.5, 2.0), 30: (0.5, 1.0), 60: (0.2, 0.5)}),
        (evenly, {3: (1.0, 6.0), 30: (0.7, 2.0), 60: (0.5, 1.2)}),
    ],
)
def test_the_other_clock_is_known_to_a_hundredth_of_the_longest_delay(
    delay: Delay, bounds: Mapping[float, tuple[float, float]]
) -> None:
    check(delay, bounds)


def test_an_estimate_knows_its_error() -> None:
    within = 0
    for seed in range(40):
        pair = Pair(seed, mostly_short)
        found = estimate(pair.known(5), 5.0)
        assert found
        within += abs(found.offset - (pair.remote(5.0) - 5.0)) <= found.error
    assert within >= 36


def test_a_link_without_jitter_is_known_at_once_and_another_after_three_seconds() -> None:
    quick = Pair(1, lambda dice: 0.0002)
    exchanges = quick.known(1.1)
    found = estimate(exchanges, 1.1)
    assert found
    assert is_known(exchanges, found)
    slow = Pair(1, evenly)
    for seconds, known in ((1.5, False), (3.1, True)):
        exchanges = slow.known(seconds)
        found = estimate(exchanges, seconds)
        assert found
        assert is_known(exchanges, found) == known


def test_nothing_is_known_from_a_few_exchanges() -> None:
    assert estimate(Pair(1, evenly).known(0.5), 0.5) is None


def test_old_exchanges_are_forgotten() -> None:
    exchanges = Pair(1, evenly).known(200)
    assert len(exchanges.down) < 65
    assert len(exchanges.up) < 65


@pytest.mark.parametrize("slept", [-10.0, 10.0, 0.5, -0.5], ids=lambda slept: f"{slept:g} s")
def test_a_clock_that_has_jumped_is_known_again_after_a_second(slept: float) -> None:
    pair = Pair(1, mostly_short, 0.0)
    exchanges = pair.known(20)
    pair.offset += slept
    for each in pair.exchanges(2):
        exchanges = noted(exchanges, replace(each, sent=each.sent + 20, heard=each.heard + 20))
    found = estimate(exchanges, 22.0)
    assert found
    assert found.offset == pytest.approx(pair.offset - 20, abs=0.01)


def test_readings_of_the_clocks_never_go_back_and_have_no_gap() -> None:
    clock = steered(None, Estimated(0.0, 100.0, 0.0, 0.001, 0.01))
    dice = random.Random(1)
    before = clock.remote(0.0)
    for tick in range(1, 500):
        now = tick / 10
        after = clock.remote(now)
        assert after > before
        assert clock.local(after) == pytest.approx(now, abs=1e-9)
        before = after
        found = Estimated(now, 100.0 + dice.uniform(-0.01, 0.01), dice.uniform(-1e-4, 1e-4), 0.001, 0.01)
        clock = steered(clock, found)
        assert clock.remote(now) == pytest.approx(after, abs=1e-9)


@pytest.mark.parametrize(("off", "after_a_second"), [(SLEW / 2, SLEW / 2), (-SLEW * 2, -SLEW), (STEP * 2, STEP * 2)])
def test_a_difference_is_made_up_slowly_unless_it_is_large(off: float, after_a_second: float) -> None:
    clock = steered(RemoteClock(0.0, 5.0), Estimated(10.0, 5.0 + off, 0.0, 0.0, 0.0))
    assert clock.remote(11.0) - 11.0 - 5.0 == pytest.approx(after_a_second)
