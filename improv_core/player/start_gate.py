"""What holds beat 0 back once everything is ready: a person, a time on the wall clock, a count. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from improv_core.protocol.messages import Armed, Arming

LATE = 0.01
"""Seconds after its time from which a beginning is late, and people are told."""


@dataclass(frozen=True, slots=True)
class Gate:
    """Beat 0 waits for a person, or until the wall clock says `begins`, in Unix time. It is `ready` once it waits for
    nothing else. `opened` is when a person opened it, in monotonic seconds: then is beat 0, for the stages on other
    machines too if it is `shared`. With `at_bar`, a clock that is followed says when its next bar begins, and so do we.

    So many beats, the `count`, are counted before beat 0, each of `period` seconds (0: not yet known). Once it is
    ready, they are counted at once if it opens `by_itself`, and otherwise when a person opens it, or before its time.
    """

    begins: float = math.inf
    ready: bool = False
    opened: float | None = None
    at_bar: bool = False
    count: int = 0
    period: float = 0.0
    by_itself: bool = False
    shared: bool = False

    def is_open(self, wall: float) -> bool:
        return wall >= self.begins


def made_of(arming: Arming | None, *, shared: bool = False) -> Gate | None:
    """The gate that somebody has asked for."""
    return None if arming is None else Gate(arming.get("begins", math.inf), shared=shared)


def counted(gate: Gate | None, beats: int) -> Gate:
    """A gate before which so many beats are counted; without one, they begin once everything is ready."""
    return replace(gate or Gate(by_itself=True), count=beats)


def made_ready(gate: Gate, now: float, wall: float, period: float) -> Gate:
    """A gate once everything is ready, with beats of `period` seconds."""
    if gate.count and gate.by_itself:
        return counting(gate, now, wall, period)
    return replace(gate, ready=True, period=period if gate.count else 0.0)


def counting(gate: Gate, now: float, wall: float, period: float) -> Gate:
    """A gate whose count begins now. The beats that it counts end at beat 0, which is known from here on."""
    left = gate.count * period
    return replace(gate, ready=True, begins=wall + left, opened=now + left, period=period)


def counts(gate: Gate, wall: float) -> bool:
    """Whether the beats before beat 0 are being counted."""
    return gate.ready and gate.count > 0 and gate.begins - wall <= gate.count * gate.period


def begins_to_count(before: Gate | None, after: Gate | None) -> bool:
    """Whether it has become known when a count ends."""
    if not before or not after or not before.ready:
        return False
    return after.count > 0 and before.begins != after.begins


def beat_zero(gate: Gate | None, now: float) -> float:
    """When beat 0 is, in monotonic seconds: as its gate was opened, unless robots were still looked at for long."""
    return gate.opened if gate and gate.opened is not None and abs(now - gate.opened) < LATE else now


def passed(gate: Gate | None, now: float) -> float:
    """Seconds since other stages have begun, if this one is late: it has to begin where they are."""
    late = now - gate.opened if gate and gate.shared and gate.opened is not None else 0.0
    return late if late >= LATE else 0.0


def is_ready(gate: Gate | None) -> bool:
    """Whether beat 0 waits for nothing but this gate, and people are to know: a bar comes soon by itself."""
    return gate is not None and gate.ready and not (gate.at_bar and gate.begins < math.inf)


def time_left(gate: Gate, wall: float) -> float:
    """Seconds until a gate opens by itself, once it is all that is waited for; otherwise 0."""
    return max(gate.begins - wall, 0.0) if gate.ready else 0.0


def lateness(gate: Gate | None, wall: float) -> str:
    """The line about a beginning that comes late; empty if it doesn't, or if it catches up with a clock."""
    late = wall - gate.begins if gate and gate.begins > -math.inf and not gate.at_bar else 0.0
    return f"begins {late:.2f} s late: robots were still waited for, or the clock was set" if late > LATE else ""


def message(gate: Gate | None, generation: int) -> Armed:
    """What people are shown: whether a score is armed, and when it begins by itself."""
    armed = gate if is_ready(gate) else None
    begins = armed.begins if armed and armed.begins < math.inf else None
    told: Armed = {"type": "armed", "generation": generation, "armed": armed is not None, "begins": begins}
    if armed and begins and armed.count:
        told["count"] = {"beats": armed.count, "period": armed.period}
    return told
