"""Inlay hints: the lengths of statements, the rates of nested brackets, the parameters of arguments, and, for editors
that can't light words, the beats that lines which play have reached."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from improv_core.ide.cursor import touching
from improv_core.ide.hover import pace_in
from improv_core.ide.phrases import arguments, label, parameters
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.program.timing import deciding, in_beats, lasting, times_as_fast, written
from improv_core.score.algebra import FromStatement, items_of
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Exact, near
from improv_core.score.replay import Replay
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class Hint:
    """A few characters after an offset, or before it if `before`. `about` is the explanation."""

    offset: int
    text: str
    about: str
    before: bool = False


def hints(analysis: Analysis, span: Span) -> list[Hint]:
    """Return the hints for all statements without errors that touch a span, in the order of the text."""
    return [hint for placed in touching(analysis, span) for hint in _hints(analysis, placed)]


def _hints(analysis: Analysis, placed: Placed) -> Iterator[Hint]:
    checkpoint()
    body, meaning = placed.body, placed.meaning
    if not body or placed.index in analysis.lacks:
        return
    for hint in (*_nested(body, ()), *_arguments(analysis, placed, body)):
        yield Hint(placed.start + hint.offset, hint.text, hint.about, hint.before)
    end = placed.start + body.span.end
    if not placed.statement.parameters:  # otherwise it depends on the arguments
        lasts = lengths(meaning.movement)
        about = lasting(lasts, analysis.tempo) if lasts.is_fixed else deciding(meaning.movement)
        yield Hint(end, in_beats(lasts), about)


def _nested(node: Node, outside: tuple[Node, ...]) -> Iterator[Hint]:
    """Yield the rate of each voice of a nested bracket."""
    around = (*outside, node)
    if _squeezes(node) and any(map(_squeezes, outside)):
        for body in nodes.children(node):
            for voice in nodes.voices(body):
                rate, _, _ = pace_in((*around, body, voice))
                if rate != 1:
                    yield Hint(voice.span.start, f"×{written(rate)}", times_as_fast(rate), before=True)
    for child in nodes.children(node):
        yield from _nested(child, around)


def _arguments(analysis: Analysis, placed: Placed, body: Node) -> Iterator[Hint]:
    """Yield the parameter before each argument."""
    for node in nodes.nodes(body):
        if isinstance(node, nodes.Call):
            taken = parameters(analysis, node.name.text, placed.index)
            head = label(node.name.text, taken)[0]
            for parameter, argument in arguments(node, taken):
                checkpoint()
                yield Hint(argument.span.start, f"{parameter.name}:", head, before=True)


def _squeezes(node: Node) -> bool:
    return isinstance(node, nodes.Bracket) and node.squeezes


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
        lines = [each for each in items_of(scene) if isinstance(each, FromStatement)]
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
