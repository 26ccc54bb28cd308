"""The parameters of phrases in a statement, and the arguments of their uses."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from improv_core.program.analysis import Analysis
from improv_core.program.definitions import TO
from improv_core.program.program import Placed
from improv_core.syntax.characters import HASHES, SPACES
from improv_core.syntax.nodes import Call, Node, Number, Parameter, PoseTerm, nodes
from improv_core.text import Span

MAX_COMMENT = 10
"""The most lines of a comment that are shown."""
_COMMENT = re.compile(rf"[ \t\ufeff{SPACES}]*[{HASHES}][{HASHES} \t]*(.*)")


def parameters(analysis: Analysis, name: str, before: int) -> Sequence[Parameter]:
    """Return the parameters of a name that is used in the statement `before` and is not one of its parameters."""
    definer = analysis.bindings.definer(name, before)
    return () if definer is None else analysis.statements[definer].parameters


def poses_at(placed: Placed) -> set[Span]:
    """Return the names of poses in a statement: they are not names of the program. Spans count from its start."""
    every = nodes(placed.body) if placed.body and TO in placed.statement.uses else ()
    return {each.pose.span for each in every if isinstance(each, PoseTerm)}


def movements(taken: Sequence[Parameter]) -> int:
    """Return the number of these parameters that are movements."""
    return sum(not each.is_number for each in taken)


def arguments(call: Call, taken: Sequence[Parameter]) -> Iterator[tuple[Parameter, Number | Node]]:
    """Yield the parameters of a phrase, each with its argument in a use, as far as there are any."""
    yield from zip((each for each in taken if each.is_number), call.numbers, strict=False)
    yield from zip((each for each in taken if not each.is_number), call.movements, strict=False)


def label(name: str, taken: Sequence[Parameter]) -> tuple[str, tuple[Span, ...]]:
    """Return the head of a phrase, `times n (m)`, and the spans of its parameters in it."""
    text, spans = name, []
    for each in taken:
        shown = each.name if each.is_number else f"({each.name})"
        spans.append(Span(len(text) + 1, len(text) + 1 + len(shown)))
        text = f"{text} {shown}"
    return text, tuple(spans)


def comment(analysis: Analysis, definer: int) -> str:
    """Return the lines of comment right above a definition, without their `#`."""
    lines = analysis.lines
    number = lines.position(analysis.offsets[definer]).line
    found: list[str] = []
    while number and len(found) < MAX_COMMENT and (match := _COMMENT.fullmatch(lines.line(number - 1))):
        found.insert(0, match[1])
        number -= 1
    return "\n".join(found)
