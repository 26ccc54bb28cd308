"""The gate that holds beat 0 back once all else is ready: for a person, a time, or a count-in. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from improv_core.protocol.messages import Armed

LATE = 0.01
"""Seconds after its time from which on a beginning is late, and people get a line about it."""


@dataclass(frozen=True, slots=True)
class Gate:
    """A gate before beat 0, which waits for a person, or for a time."""

    begins: float = math.inf
    """The time at which it opens by itself, in Unix time."""
    ready: bool = False
    """True once it waits for nothing else."""
    opened: float | None = None
    """The time at which it opens in monotonic seconds, once a person, a count, or a bar has set that: beat 0 is then.
    From there on, nobody changes it by setting the wall clock."""
    at_bar: bool = False
    """True if it opens at the next bar of a clock that is followed."""
    count: int = 0
    """The number of beats that are counted before beat 0."""
    period: float = 0.0
    """Seconds of each of these beats; 0 if not yet known."""
    by_itself: bool = False
    """True if they are counted once it is ready; otherwise, when a person opens it, or before its time."""
    shared: bool = False
    """True if beat 0 is at the same time on other machines."""

    def late(self, now: float, wall: float) -> float:
        """Return how many seconds ago it opened; a negative number before that."""
        return wall - self.begins if self.opened is None else now - self.opened


def counted(gate: Gate | None, beats: int) -> Gate:
    """Return a gate before which this many beats are counted; without one, they begin once everything is ready."""
    return replace(gate or Gate(by_itself=True), count=beats)


def made_ready(gate: Gate, now: float, wall: float, period: float) -> Gate:
    """Return a gate once everything is ready, with beats of `period` seconds."""
    if gate.count and gate.by_itself:
        return counting(gate, now, wall, period)
    return replace(gate, ready=True, period=period if gate.count else 0.0)


def counting(gate: Gate, now: float, wall: float, period: float) -> Gate:
    """Return a gate whose count begins now. Its beats end at beat 0, whose time is known from here on."""
    left = gate.count * period
    return replace(gate, ready=True, begins=wall + left, opened=now + left, period=period)


def counts(gate: Gate, now: float, wall: float) -> bool:
    """Return whether the beats before beat 0 are being counted."""
    return gate.ready and gate.count > 0 and -gate.late(now, wall) <= gate.count * gate.period


def is_news(before: Gate | None, after: Gate | None) -> bool:
    """Return whether people should know of a change: beat 0 waits only for the gate now, or no longer does, or the end
    of a count has just become known."""
    if is_ready(before) != is_ready(after):
        return True
    return bool(before and after and before.ready and after.count and before.begins != after.begins)


def beat_zero(gate: Gate, now: float) -> float:
    """Return beat 0 in monotonic seconds: when its gate opened, unless checks of robots took long after that."""
    return gate.opened if gate.opened is not None and abs(now - gate.opened) < LATE else now


def passed(gate: Gate, now: float) -> float:
    """Return the seconds since other stages have begun, if this one is late: it has to begin where they are."""
    late = now - gate.opened if gate.shared and gate.opened is not None else 0.0
    return late if late >= LATE else 0.0


def is_ready(gate: Gate | None) -> bool:
    """Return whether beat 0 waits only for this gate, and people should know. They needn't if a bar opens it soon."""
    return gate is not None and gate.ready and not (gate.at_bar and gate.begins < math.inf)


def time_left(gate: Gate, now: float, wall: float) -> float:
    """Return the seconds until a gate opens by itself, if nothing else has to be waited for; otherwise 0."""
    return max(-gate.late(now, wall), 0.0) if gate.ready else 0.0


def lateness(gate: Gate, now: float, wall: float) -> str:
    """Return the line about a late beginning; empty if it is in time, or if it catches up with a clock."""
    late = gate.late(now, wall) if gate.begins > -math.inf and not gate.at_bar else 0.0
    return f"begins {late:.2f} s late: the stage still waited for robots, or the clock was set" if late > LATE else ""


def message(gate: Gate | None, generation: int) -> Armed:
    """Return the message that shows whether a score is armed, and when it begins by itself."""
    armed = gate if is_ready(gate) else None
    begins = armed.begins if armed and armed.begins < math.inf else None
    told: Armed = {"type": "armed", "generation": generation, "armed": armed is not None, "begins": begins}
    if armed and begins and armed.count:
        told["count"] = {"beats": armed.count, "period": armed.period}
    return told
