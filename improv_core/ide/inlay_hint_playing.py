"""Inlay hints at the lines that play now: which of its beats each has reached. For editors that can't light words."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import islice

from improv_core.ide.inlay_hint import Hint
from improv_core.ide.moments import MOST_PERFORMED, SoFar
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.score.algebra import Series, Use
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Exact, Movement, near
from improv_core.score.performance import SenseEdge, performed
from improv_core.score.scenes import scene_begins


def playing_hints(played: Analysis, now: Analysis, beat: float, so_far: SoFar) -> list[Hint]:
    """The hints for a program as it is played at a beat, in a later version of its text, in the order of that text."""
    places = {statement: index for index, statement in enumerate(now.statement_ids)}
    found: dict[int, Hint] = {}
    for robot, (line, passed) in _lines(played, near(max(beat, 0.0)), so_far).items():
        index = places.get(line.statement)  # a line that was edited since is left out
        body = None if index is None else now.statements[index].body
        if index is not None and body and index not in found:
            offset = now.offsets[index] + body.span.end
            found[index] = Hint(offset, _shown(line, passed), f"{printable(robot)} plays this line now")
    return [found[index] for index in sorted(found)]


def _shown(line: Use, passed: Exact) -> str:
    """`beat 3/8`, counted from 1, as people do."""
    length = lengths(line)
    whole = "∞" if length.shortest == ENDLESS else str(math.ceil(length.shortest)) if length.is_fixed else ""
    return f"beat {math.floor(passed) + 1}{whole and '/'}{whole}"


def _lines(played: Analysis, beat: Exact, so_far: SoFar) -> dict[str, tuple[Use, Exact]]:
    """The line that each robot plays at a beat, and how many beats ago it began."""
    scenes = {robot: movements[so_far.scene :] for robot, movements in played.parts.items()}
    entered = {robot: near(so_far.begins.get(robot, 0)) for robot in scenes}
    begins = scene_begins(scenes.values(), near(so_far.since), list(entered.values()))
    scene = max(bisect_right(begins, beat) - 1, 0)
    found = {}
    for robot, movements in scenes.items():
        begin = begins[scene] if scene else entered[robot]
        edges = [edge for edge in so_far.edges if edge.robot == robot] if not scene else []
        if line := _line(movements[scene], beat, begin, edges):
            found[robot] = line
    return found


def _line(scene: Movement, beat: Exact, begin: Exact, edges: Sequence[SenseEdge]) -> tuple[Use, Exact] | None:
    """The line of a robot's scene, which began at beat `begin`, that plays at a beat, and how long ago it began."""
    lines = [each for each in (scene.items if isinstance(scene, Series) else (scene,)) if isinstance(each, Use)]
    if beat < begin:
        return None
    if not scene.open:
        for line in lines:
            if beat < begin + line.duration:
                return line, beat - begin
            assert not isinstance(line.duration, float)
            begin += line.duration
        return None
    by_statement = {line.statement: line for line in lines}
    current: Use | None = None
    for moment in islice(performed(scene, begin, edges), MOST_PERFORMED):
        line_now = by_statement.get(moment.sources[0].statement) if moment.sources else None
        if line_now and line_now is not current:
            current, begin = line_now, moment.start
        if beat < moment.start + moment.duration:
            return (current, beat - begin) if current else None
    return None
