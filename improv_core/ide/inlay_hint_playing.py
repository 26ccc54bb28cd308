"""Inlay hints at the lines that play now: the beat that each has reached. For editors that can't light words."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence

from improv_core.ide.inlay_hint import Hint
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.score.algebra import FromStatement, Series
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Exact, near
from improv_core.score.replay import Replay


def playing_hints(replay: Replay, now: Analysis, beat: float) -> list[Hint]:
    """Return the hints for a program as it plays at a beat, in the order of a later version of its text."""
    places = {statement: index for index, statement in enumerate(now.statement_ids)}
    found: dict[int, Hint] = {}
    for robot, (line, passed) in _lines(replay, near(max(beat, 0.0))).items():
        index = places.get(line.statement)  # a line that was edited since gets no hint
        body = None if index is None else now.statements[index].body
        if index is not None and body and index not in found:
            offset = now.offsets[index] + body.span.end
            about = f"{printable(robot)} plays this line now; its beats count from 1"
            found[index] = Hint(offset, _shown(line, passed), about)
    return [found[index] for index in sorted(found)]


def _shown(line: FromStatement, passed: Exact) -> str:
    """`beat 3/8`, counted from 1, as people do."""
    length = lengths(line)
    whole = "∞" if length.shortest == ENDLESS else str(math.ceil(length.shortest)) if length.is_fixed else ""
    return f"beat {math.floor(passed) + 1}{whole and '/'}{whole}"


def _lines(replay: Replay, beat: Exact) -> dict[str, tuple[FromStatement, Exact]]:
    """Return the line that each robot plays at a beat, and the number of beats since it began."""
    score = replay.score
    passed = max(bisect_right(score.scene_begins, beat) - 1, 0)
    found = {}
    for robot, part in score.parts.items():
        scene = part.of_scene(score.scene + passed)
        begin = score.scene_begins[passed] if passed else part.begins
        lines = [
            each for each in (scene.items if isinstance(scene, Series) else (scene,)) if isinstance(each, FromStatement)
        ]
        if beat < begin:
            continue
        if passed or not replay.is_open(robot):
            line = _walked_line(lines, beat - begin)
        elif played := replay.line(robot, beat):
            line = next(((each, beat - played[1]) for each in lines if each.statement == played[0]), None)
        else:
            line = None
        if line:
            found[robot] = line
    return found


def _walked_line(lines: Sequence[FromStatement], passed: Exact) -> tuple[FromStatement, Exact] | None:
    """Return the line that plays this many beats after the first one began, and the beats since it began itself."""
    for line in lines:
        if passed < line.duration:
            return line, passed
        assert not isinstance(line.duration, float)
        passed -= line.duration
    return None
