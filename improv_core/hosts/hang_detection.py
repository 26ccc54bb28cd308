"""Whether a stage beside us hangs. Its pings come from its parent through a link that may be silent, so only those
count that have reached the stage. It never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from improv_core.protocol.limits import END_LIMIT, HANG_LIMIT, LOADING_LIMIT

HARMLESS_LIMIT = 3.0
"""Seconds that one may take to answer which moves nothing: it does no harm if late."""
STALL = 0.2
"""Seconds by which a look may be late. If it is later, we have stalled ourselves, which says nothing of the stage."""


@dataclass(frozen=True, slots=True)
class Unanswered:
    """What a stage has been asked, by number and time, and what else bears on how long it may take."""

    pings: Mapping[int, float] = field(default_factory=dict)
    loads: bool = False
    """A score was sent to it, and it has yet to answer the ping behind that."""
    behind: int | None = None
    """The number of that ping, once it was sent."""
    plays: bool = False
    since: float = math.inf
    """Only from then on, time counts: never before it is ready."""
    looked: float = 0.0


def pinged(asked: Unanswered, number: int, now: float, *, behind_score: bool = False) -> Unanswered:
    """A ping reaches the stage; perhaps that behind a score."""
    pings = {**asked.pings, number: now}
    return replace(asked, pings=pings, behind=number) if behind_score else replace(asked, pings=pings)


def loading(asked: Unanswered) -> Unanswered:
    """A score reaches the stage."""
    return replace(asked, loads=True, behind=None)


def answered(asked: Unanswered, number: int, now: float) -> Unanswered:
    """The stage answers a ping. Those that wait behind a score are answered once that is read."""
    pings = {other: at for other, at in asked.pings.items() if other != number}
    done = number == asked.behind
    since = now if done else asked.since
    return replace(asked, pings=pings, since=since, loads=asked.loads and not done)


def ready(asked: Unanswered, now: float) -> Unanswered:
    """The stage says its first words."""
    return replace(asked, since=now)


def plays(asked: Unanswered, moves: bool) -> Unanswered:
    """The stage says whether robots move."""
    return replace(asked, plays=moves)


def stopped(asked: Unanswered, now: float) -> Unanswered:
    """The stage has said its last words. It may take some time to exit."""
    return replace(asked, since=now + END_LIMIT)


def looked(asked: Unanswered, now: float, period: float) -> tuple[Unanswered, float | None]:
    """Call this every `period` seconds: with it comes the limit in seconds that the stage has exceeded, if any."""
    since = now if now > asked.looked + period + STALL else asked.since
    asked = replace(asked, since=max(since, asked.since), looked=now)
    limit = LOADING_LIMIT if asked.loads else HANG_LIMIT if asked.plays else HARMLESS_LIMIT
    oldest = min(asked.pings.values(), default=now)
    return asked, limit if now - max(oldest, asked.since) > limit else None
