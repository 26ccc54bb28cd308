"""Detects that a stage on this machine hangs. Its pings come from its parent through a link that may be silent, so only
those count that have reached the stage. It never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from improv_core.protocol.limits import END_LIMIT, HANG_LIMIT, LOADING_LIMIT

HARMLESS_LIMIT = 3.0
"""Seconds that a stage without moving robots may take to answer: it does no harm if late."""
STALL = 0.2
"""Seconds by which a look may be late. If it is later, we have stalled ourselves, which proves nothing about the
stage."""


@dataclass(frozen=True, slots=True)
class Unanswered:
    """The pings that a stage has yet to answer, by number and time, and facts that change its time limit."""

    pings: Mapping[int, float] = field(default_factory=dict)
    loads: bool = False
    """True if the stage was sent a score, and has yet to answer the ping behind that."""
    behind: int | None = None
    """The number of that ping, once it was sent."""
    plays: bool = False
    since: float = math.inf
    """The time from which the stage's delay counts: never before it is ready."""
    looked: float = 0.0


def pinged(asked: Unanswered, number: int, now: float, *, behind_score: bool = False) -> Unanswered:
    """Note that a ping reaches the stage; perhaps the one behind a score."""
    pings = {**asked.pings, number: now}
    return replace(asked, pings=pings, behind=number) if behind_score else replace(asked, pings=pings)


def loading(asked: Unanswered) -> Unanswered:
    """Note that a score reaches the stage."""
    return replace(asked, loads=True, behind=None)


def answered(asked: Unanswered, number: int, now: float) -> Unanswered:
    """Note that the stage answers a ping. Pings behind a score get their answers once the stage has read it."""
    pings = {other: at for other, at in asked.pings.items() if other != number}
    done = number == asked.behind
    since = now if done else asked.since
    return replace(asked, pings=pings, since=since, loads=asked.loads and not done)


def ready(asked: Unanswered, now: float) -> Unanswered:
    """Note the stage's first message."""
    return replace(asked, since=now)


def plays(asked: Unanswered, moves: bool) -> Unanswered:
    """Note the stage's report whether robots move."""
    return replace(asked, plays=moves)


def stopped(asked: Unanswered, now: float) -> Unanswered:
    """Note the stage's last message. It may take some time to exit."""
    return replace(asked, since=now + END_LIMIT)


def looked(asked: Unanswered, now: float, period: float) -> tuple[Unanswered, float | None]:
    """Return it after a look, and the limit in seconds that the stage has exceeded, if any. Call this every `period`
    seconds."""
    since = now if now > asked.looked + period + STALL else asked.since
    asked = replace(asked, since=max(since, asked.since), looked=now)
    limit = LOADING_LIMIT if asked.loads else HANG_LIMIT if asked.plays else HARMLESS_LIMIT
    oldest = min(asked.pings.values(), default=now)
    return asked, limit if now - max(oldest, asked.since) > limit else None
