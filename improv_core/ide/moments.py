"""Which words play when: for editors that light them up by a clock of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from improv_core.program.analysis import Analysis
from improv_core.score.movement import near
from improv_core.score.walk import walk
from improv_core.text import Span

MOST_MOMENTS = 4_000
MOST_WORDS = 40_000
"""Of all robots together in one answer, though at least one moment of each; an editor that needs more asks again."""


@dataclass(frozen=True, slots=True)
class Moment:
    """From beat `start` to beat `end`, the words at these spans play."""

    start: float
    end: float
    spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True)
class Stretch:
    """What one robot plays, up to beat `until`; None if that is all."""

    moments: tuple[Moment, ...]
    until: float | None


def playing(played: Analysis, now: Analysis, start: float = 0.0) -> Mapping[str, Stretch]:
    """What the robots of a program play from a beat on, and where that stands in a later version of its text.

    Words of statements that have been edited since are left out; those that only moved are found.
    """
    begin = near(max(start, 0.0))
    robots = max(len(played.robots), 1)
    starts = dict(zip(now.statement_ids, now.offsets, strict=True))
    stretches = {}
    for robot, movement in played.robots.items():
        moments: list[Moment] = []
        words, until = 0, None
        for moment in walk(movement, begin) if begin < movement.duration else ():
            words += len(moment.places)
            if moments and (len(moments) == MOST_MOMENTS // robots or words > MOST_WORDS // robots):
                until = float(moment.start)
                break
            spans = tuple(
                place.span.shifted(starts[place.statement]) for place in moment.places if place.statement in starts
            )
            moments.append(Moment(float(moment.start), float(moment.start + moment.duration), spans))
        stretches[robot] = Stretch(tuple(moments), until)
    return stretches
