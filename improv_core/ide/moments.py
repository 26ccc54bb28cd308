"""Which words play when, for editors that highlight them by their own clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from improv_core.program.analysis import Analysis
from improv_core.score.movement import near
from improv_core.score.walk import walk
from improv_core.text import Span

MOST_MOMENTS = 4_000
MOST_WORDS = 40_000
"""The most words of all robots in one response, though at least one moment of each. The client asks for more when it
needs them."""
_AT_BEAT_0: Mapping[str, float] = {}


@dataclass(frozen=True, slots=True)
class Moment:
    """From beat `start` to beat `end`, the words at these spans play."""

    start: float
    end: float
    spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True)
class Stretch:
    """What one robot plays up to beat `until` (None: to the end)."""

    moments: tuple[Moment, ...]
    until: float | None


def playing(
    played: Analysis, now: Analysis, start: float = 0.0, begins: Mapping[str, float] = _AT_BEAT_0
) -> Mapping[str, Stretch]:
    """What the robots of a program play from a beat on, with spans in a later version of its text.

    `begins` has the beats at which parts began that did not begin at beat 0.

    Words of statements that were edited since are left out. Those that only moved are included.
    """
    begin = near(max(start, 0.0))
    robots = max(len(played.robots), 1)
    offsets = dict(zip(now.statement_ids, now.offsets, strict=True))
    stretches = {}
    for robot, movement in played.robots.items():
        moments: list[Moment] = []
        words, until = 0, None
        began = near(begins.get(robot, 0))
        passed = max(begin - began, 0)
        for moment in walk(movement, passed) if passed < movement.duration else ():
            words += len(moment.sources)
            if moments and (len(moments) == MOST_MOMENTS // robots or words > MOST_WORDS // robots):
                until = float(began + moment.start)
                break
            spans = tuple(
                source.span.shifted(offsets[source.statement])
                for source in moment.sources
                if source.statement in offsets
            )
            since = began + moment.start
            moments.append(Moment(float(since), float(since + moment.duration), spans))
        stretches[robot] = Stretch(tuple(moments), until)
    return stretches
