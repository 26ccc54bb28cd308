"""Inlay hints: the lengths of statements, the rates of nested brackets, and the parameters of arguments."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from improv_core.ide.cursor import touching
from improv_core.ide.hover import pace_in
from improv_core.ide.phrases import arguments, label, parameters
from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.program.timing import deciding, in_beats, lasting, times_as_fast, written
from improv_core.score.lengths import lengths
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
    if not body or not meaning.ok:
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
            for voice in body.voices if isinstance(body, nodes.Parallel) else (body,):
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
