"""Performs a whole score whose senses are scripted: no clock, no robots. Standard library only."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from improv_core.score.movement import ENDLESS, STILL, Duration, Exact, Movement
from improv_core.score.performer import Performer
from improv_core.score.walk import Moment


class SenseSpan(NamedTuple):
    """A sense that holds from a beat to another, which is excluded, or at an instant if they are the same.

    Without a robot, it holds for all of them.
    """

    sense: str
    robot: str | None
    start: Exact
    end: Duration = ENDLESS

    def holds(self, robot: str, sense: str, beat: Exact) -> bool:
        mine = self.sense == sense and self.robot in (None, robot)
        return mine and (self.start <= beat < self.end or self.start == beat == self.end)


class Mover(NamedTuple):
    """The base of a robot, or one of its body parts."""

    robot: str
    part: str = ""

    def __str__(self) -> str:
        return f"{self.robot}'s {self.part}" if self.part else self.robot


class PlayedMoment(NamedTuple):
    """A moment of a robot or a body part, in a scene that is counted from 0."""

    scene: int
    mover: Mover
    moment: Moment


def perform(scenes: Sequence[Mapping[Mover, Movement]], script: Sequence[SenseSpan]) -> Iterator[PlayedMoment]:
    """Yield the moments of each robot and each body part, in order of time. Each scene lists all of them.

    A scene begins on the first whole beat at which everything before it is over. Until then a robot that is done
    stands, unless it plays in no later scene.
    """
    last = {robot: place for place, scene in enumerate(scenes) for robot, each in scene.items() if _may_play(each)}
    changes = sorted({beat for sensing in script for beat in (sensing.start, sensing.end)})
    spans: dict[tuple[str | None, str], list[SenseSpan]] = {}
    for each in script:
        spans.setdefault((each.robot, each.sense), []).append(each)
    beat: Exact = 0
    for index, scene in enumerate(scenes):
        performers = {robot: Performer(movement, beat) for robot, movement in scene.items()}
        staying = [robot for robot in scene if index < last.get(robot, 0)]
        while playing := [robot for robot, performer in performers.items() if _plays(performer, robot, spans)]:
            changing = changes[bisect_right(changes, beat) :][:1]
            until = min([*(performers[robot].until for robot in playing), *changing])
            assert not isinstance(until, float)
            for robot, performer in performers.items():
                if robot in playing:
                    performed = performer.performed(partial(_holds, spans, robot, beat))
                    yield PlayedMoment(index, robot, Moment(beat, until - beat, *performed))
                    performer.advance(until)
                elif robot in staying:
                    yield PlayedMoment(index, robot, Moment(beat, until - beat, STILL, ()))
            beat = until
        if rest := math.ceil(beat) - beat:
            for robot in staying:
                yield PlayedMoment(index, robot, Moment(beat, rest, STILL, ()))
        beat = math.ceil(beat)


def _may_play(movement: Movement) -> bool:
    return movement.open or bool(movement.duration)


_Spans = Mapping[tuple[str | None, str], Sequence[SenseSpan]]
"""The spans of each sense of each robot, or of all."""


def _plays(performer: Performer, robot: Mover, spans: _Spans) -> bool:
    performer.settle(partial(_holds, spans, robot, performer.beat))
    return not performer.is_over


def _holds(spans: _Spans, mover: Mover, beat: Exact, sense: str) -> bool:
    return any(
        each.holds(mover.robot, sense, beat) for robot in (mover.robot, None) for each in spans.get((robot, sense), ())
    )
