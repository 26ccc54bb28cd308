"""A code action that joins lines on which robots do the same, one after the other, into one line with `canon`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import Action
from improv_core.ide.fragment import is_broken
from improv_core.program.analysis import Analysis
from improv_core.program.numbers import LONGEST_NUMBER
from improv_core.program.program import Placed
from improv_core.syntax import nodes
from improv_core.syntax.lexer import lex
from improv_core.text import Span


class _Entry(NamedTuple):
    """A line of one robot: the beats that it rests first, and the movement that follows."""

    placed: Placed
    rests: int
    text: str
    is_term: bool

    @property
    def robot(self) -> str:
        return self.placed.meaning.robots[0]

    @property
    def words(self) -> list[str]:
        return [token.text for token in lex(self.text)]


def as_canon(analysis: Analysis, span: Span) -> Iterator[Action]:
    """Join the lines around the cursor whose robots do the same, each as many beats after the one before it."""
    placed = analysis.statement_at(span.start)
    here = _entry(analysis, placed.index) if placed else None
    if not here:
        return
    lines = [here]
    while (above := _entry(analysis, lines[0].placed.index - 1)) and above.words == here.words:
        lines.insert(0, above)
    while (below := _entry(analysis, lines[-1].placed.index + 1)) and below.words == here.words:
        lines.append(below)
    robots = [line.robot for line in lines]
    if len(set(robots)) < max(len(robots), 2):
        return
    step = lines[1].rests
    if step == 0 or [line.rests for line in lines] != [step * place for place in range(len(lines))]:
        return
    top = lines[0]
    text = top.text if top.is_term else f"({top.text})"
    first = Edit(top.placed.span, f"{' '.join(robots)} $ canon {step} {text}")
    gone = (Edit(analysis.lines.whole(line.placed.span), "") for line in lines[1:])
    yield Action(f"Write {len(lines)} lines as canon {step}", "refactor.rewrite", (first, *gone))


def _entry(analysis: Analysis, index: int) -> _Entry | None:
    if not 0 <= index < len(analysis.statements):
        return None
    placed = analysis.placed(index)
    body = placed.body
    if not body or len(placed.meaning.robots) != 1 or is_broken(placed) or len(placed.statement.heads) != 1:
        return None
    items = body.items if isinstance(body, nodes.Series) else (body,)
    rests, count = 0, 0
    for item in items:
        beats = _rest(item)
        if beats is None:
            break
        rests, count = rests + beats, count + 1
    played = items[count:]
    if not played:
        return None
    text = placed.statement.text[played[0].span.start : body.span.end]
    return _Entry(placed, rests, text, len(played) == 1 and not isinstance(played[0], nodes.Parallel))


def _rest(node: nodes.Node) -> int | None:
    """Return the beats of `rest` or `repeat 4 rest`; None for anything else."""
    if isinstance(node, nodes.Primitive) and node.word.text == "rest":
        return 1
    if isinstance(node, nodes.Apply) and node.word.text == "repeat" and node.numbers and _rest(node.body) == 1:
        number = node.numbers[0].text
        return int(number) if number.isdecimal() and len(number) < LONGEST_NUMBER else None
    return None
