"""The next decision of a performance, and the order of things that are due at the same instant."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from improv_core.player.run import Run
from improv_core.score.movement import Duration, Exact

SAME = 1e-7
"""Seconds. Times that differ by less are the same instant: times computed in different ways are rounded differently."""


class Rank(IntEnum):
    """The order at one instant. Each comes before the next, for these reasons:

    - `SCENE`: at the beginning of a scene, only its own setpoints count. Those that the scene before had left for that
      instant are dropped. A score that takes over right then finds the new scene, and edits that one.
    - `TAKEOVER`: likewise, an edited robot gets the new score's setpoint and not the old one's. Robots that play on get
      theirs as part of the takeover, before anything is prepared for the others.
    - `EDGES`: an edge counts for everything that is decided at its instant.
    - `CHANGES`: changes of velocity are exact, and are sent before anything slower is done.
    - `END`: the zeros that end the last parts still belong to the score. Only then does it end.
    - `BEND`: the pace changes once all that is due now is done.
    - `REPEATS`: a repeated velocity may be about to change, and a repeat may be a little late.

    Listeners have no rank: they are checked when nothing is due, because that takes longest.
    """

    SCENE = 0
    TAKEOVER = 1
    EDGES = 2
    CHANGES = 3
    END = 4
    BEND = 5
    REPEATS = 6


class Due(NamedTuple):
    """Something that is due at a performance time. The lowest comes first."""

    at: float
    rank: Rank

    def last_before(self, rank: Rank) -> float:
        """Return the latest time at which something of another rank still comes before this."""
        return self.at if rank < self.rank else self.at - SAME

    def is_due(self, performed: float) -> bool:
        """Return whether it is due at a performance time, or precedes something that is."""
        return self.at <= performed + (SAME if self.rank < Rank.CHANGES else 0.0)


NEVER = Due(math.inf, Rank.END)


def next_decision(run: Run, over: Duration) -> Due:
    """Return the next thing to decide: the next scene, a takeover, the end, or the pace."""
    due = NEVER
    if run.mode == "playing":
        due = Due(run.transport.end(run.ends(over)), Rank.SCENE if run.has_next_scene else Rank.END)
    if run.clock and (run.mode == "playing" or (run.mode == "paused" and run.continues)):
        due = min(due, Due(run.clock.looks, Rank.BEND))
    if run.next and run.mode != "paused":
        due = min(due, Due(run.next.at, Rank.TAKEOVER))
    return due


def next_edges(run: Run, announced: Exact | None) -> Due:
    if announced is None or run.mode != "playing":
        return NEVER
    return Due(run.transport.end(announced), Rank.EDGES)


def performed(run: Run, now: float, due: float) -> float:
    """Return the performance time at a time on the clock. Rounding never puts it before something due on the clock."""
    raw = run.transport.performed(now)
    return max(raw, due) if run.transport.clock(due) <= now else raw
