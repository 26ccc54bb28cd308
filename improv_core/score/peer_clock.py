"""Another clock, which ours follows: its position and its rate, as far as its messages show them, and the rate at which
ours has to play so that both meet. Pure functions; nothing here reads a clock. Standard library only.

Messages come late or early by some milliseconds, drift, ramp, jump, or don't come at all. The estimate is a growing-
and then a fading-memory polynomial filter (Morrison, Introduction to Sequential Smoothing and Prediction, 1969): of
degree 1 until many messages have come, and then of degree 2, which doesn't lag behind a steady ramp.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

FADING = 2.0
"""The rate at which old sightings lose weight, per second. Twice as much follows an accelerando, and jitter, sooner."""
STRAY = 0.1
"""Seconds by which a sighting may be off. Beyond that, it is a hiccup of this machine, or the clock has jumped."""
USUAL = 0.01
"""Seconds by which a sighting may usually be off. A sighting that is off by more was delayed, and counts as off by
this."""
JUMPED = 0.25
"""Seconds of nothing but strays after which the clock has jumped."""
GAP = 0.5
"""Seconds of silence after which a stray is a jump at once: the clock stood still meanwhile."""
KNOWN = 0.4
"""Seconds of sightings after which the rate of a clock is known."""
FEW = 4
"""The least number of sightings until then."""
SOONEST = 0.004
"""The least seconds between two sightings: those that come closer together have waited somewhere, and tell less."""
LIKELY = 4.0
"""The factor by which a clock may run faster or slower after a jump. Anything else is a hiccup of this machine."""
TRUSTED = 8
"""The number of sightings that the rate counts for that is kept when a clock has jumped."""
MAX_BENT = 0.05
"""The share of a clock's rate by which ours may be faster or slower, to meet it."""
SETTLE = 0.5
"""Seconds in which most of an error that is small is corrected."""


@dataclass(frozen=True, slots=True)
class Anchor:
    """At `at` seconds on our clock, another one was at `phase`, in its own units, and made `rate` units a second.

    `period` is the usual number of seconds between two sightings, and `jumps` the number of its jumps.
    """

    at: float
    phase: float
    rate: float
    period: float
    jumps: int = 0

    def phase_at(self, now: float) -> float:
        """Return its phase at a time on our clock if it continues like this."""
        return self.phase + (now - self.at) * self.rate


@dataclass(frozen=True, slots=True)
class Estimate:
    """The estimate of a clock: its `anchor`, the change of its rate (units per s²), the number of sightings behind
    that, the time of the first one, and the time and phase since which there were only strays."""

    anchor: Anchor
    change: float = 0.0
    seen: int = 1
    since: float = 0.0
    strayed: tuple[float, float] | None = None

    @property
    def is_known(self) -> bool:
        return self.seen >= FEW and self.anchor.at - self.since >= KNOWN


def first_seen(at: float, phase: float) -> Estimate:
    return Estimate(Anchor(at, phase, 0.0, 0.0), since=at)


def jumped(estimate: Estimate, at: float, phase: float) -> Estimate:
    """Return the estimate of a clock that is known to be somewhere else now. It runs as fast as before."""
    anchor = replace(estimate.anchor, at=at, phase=phase, jumps=estimate.anchor.jumps + 1)
    return replace(estimate, anchor=anchor, change=0.0, seen=min(estimate.seen, TRUSTED), strayed=None)


def sighted(estimate: Estimate, at: float, phase: float, gap: float = GAP) -> Estimate:
    """Return the estimate after a sighting at `phase` at a time on our clock, unless it comes with the one before.

    After a `gap` in seconds, a stray is a jump at once.
    """
    anchor = estimate.anchor
    passed = at - anchor.at
    if passed < SOONEST:
        return estimate
    if estimate.seen == 1 and not anchor.rate:
        rate = (phase - anchor.phase) / passed
        return replace(estimate, anchor=Anchor(at, phase, rate, passed, anchor.jumps), seen=2) if rate > 0 else estimate
    expected = anchor.phase_at(at) + estimate.change * passed * passed / 2
    off = phase - expected
    if abs(off) > STRAY * anchor.rate and estimate.is_known:
        return _stray(estimate, at, phase, gap)
    if estimate.is_known:
        off = min(max(off, -USUAL * anchor.rate), USUAL * anchor.rate)
    alpha, beta, gamma = _gains(estimate.seen + 1, passed)
    rate = anchor.rate + estimate.change * passed + beta * off / passed
    if rate <= 0:
        return _stray(estimate, at, phase, gap)
    period = anchor.period + (passed - anchor.period) / min(estimate.seen, TRUSTED)
    change = estimate.change + gamma * off / passed**2
    anchor = Anchor(at, expected + alpha * off, rate, period, anchor.jumps)
    return Estimate(anchor, change, estimate.seen + 1, estimate.since)


def bent(anchor: Anchor, late: float) -> float:
    """Return the other clock's units to make in a second, in order to meet it, if ours is this many seconds late."""
    return anchor.rate * (1 + min(max(late / SETTLE, -MAX_BENT), MAX_BENT))


def _stray(estimate: Estimate, at: float, phase: float, gap: float) -> Estimate:
    """Return the estimate after a sighting that doesn't fit: ignore it, unless the clock has jumped."""
    since, first = estimate.strayed or (at, phase)
    if at - estimate.anchor.at < gap and at - since < JUMPED:
        return replace(estimate, strayed=(since, first))
    then = jumped(estimate, at, phase)
    if at - since >= JUMPED:
        rate, before = (phase - first) / (at - since), estimate.anchor.rate
        if before / LIKELY < rate < before * LIKELY:
            then = replace(then, anchor=replace(then.anchor, rate=rate))
    return then


def _gains(seen: int, passed: float) -> tuple[float, float, float]:
    """Return the shares of its error that correct its phase, its rate, and the change of that."""
    left = math.exp(-FADING * passed)
    growing, fading = 2 * (2 * seen - 1) / (seen * (seen + 1)), 1 - left**3
    if growing > fading:
        return growing, 6 / (seen * (seen + 1)), 0.0
    return fading, 1.5 * (1 - left) ** 2 * (1 + left), (1 - left) ** 3
