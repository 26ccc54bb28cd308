"""Which words play when, for editors that highlight them by their own clock."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice

from improv_core.program.analysis import Analysis
from improv_core.score.movement import Exact, Movement, near
from improv_core.score.performance import SenseEdge, performed
from improv_core.score.scenes import performance, scene_begins
from improv_core.score.walk import Moment, walk
from improv_core.text import Span

MOST_MOMENTS = 4_000
MOST_WORDS = 40_000
"""The most words of all robots in one response, though at least one moment of each. The client asks for more when it
needs them."""
MOST_PERFORMED = 10_000
"""The most moments of one scene that are looked at, where senses decide."""


@dataclass(frozen=True, slots=True)
class LitWords:
    """From beat `start` to beat `end`, the words at these spans play."""

    start: float
    end: float
    spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True)
class Stretch:
    """What one robot plays up to beat `until` (None: to the end)."""

    moments: tuple[LitWords, ...]
    until: float | None


@dataclass(frozen=True, slots=True)
class SoFar:
    """How a program has been performed so far.

    `begins` has the beats at which parts began that did not begin at beat 0, with scene `scene`, which began at beat
    `since`. `edges` are what robots have sensed since then.
    """

    begins: Mapping[str, float] = field(default_factory=dict)
    scene: int = 0
    since: float = 0.0
    edges: Sequence[SenseEdge] = ()


AT_BEAT_0 = SoFar()


def playing(played: Analysis, now: Analysis, start: float = 0.0, so_far: SoFar = AT_BEAT_0) -> Mapping[str, Stretch]:
    """What the robots of a program play from a beat on, with spans in a later version of its text.

    Words of statements that were edited since are left out. Those that only moved are included.
    """
    begin = near(max(start, 0.0))
    robots = max(len(played.robots), 1)
    offsets = dict(zip(now.statement_ids, now.offsets, strict=True))
    scenes = {robot: movements[so_far.scene :] for robot, movements in played.parts.items()}
    entered = {robot: near(so_far.begins.get(robot, 0)) for robot in scenes}
    begins = scene_begins(scenes.values(), near(so_far.since), list(entered.values()))
    stretches = {}
    for robot, movements in scenes.items():
        moments: list[LitWords] = []
        words, until = 0, None
        edges = [edge for edge in so_far.edges if edge.robot == robot]
        for moment in _moments(movements, begins, entered[robot], begin, edges):
            words += len(moment.sources)
            if moments and (len(moments) == MOST_MOMENTS // robots or words > MOST_WORDS // robots):
                until = float(moment.start)
                break
            spans = tuple(
                source.span.shifted(offsets[source.statement])
                for source in moment.sources
                if source.statement in offsets
            )
            moments.append(LitWords(float(moment.start), float(moment.start + moment.duration), spans))
        stretches[robot] = Stretch(tuple(moments), until)
    return stretches


def _moments(
    scenes: Sequence[Movement], begins: Sequence[Exact], began: Exact, begin: Exact, edges: Sequence[SenseEdge]
) -> Iterator[Moment]:
    """What a robot performs from a beat on: of a scene that senses decide, only that scene."""
    if scenes and scenes[0].open:
        for moment in islice(performed(scenes[0], began, edges), MOST_PERFORMED):
            if moment.start + moment.duration > begin:
                yield moment
        return
    whole = performance(scenes, [0, *(each - began for each in begins[1:])])
    if (passed := max(begin - began, 0)) < whole.duration:
        for moment in walk(whole, passed):
            yield moment._replace(start=began + moment.start)
