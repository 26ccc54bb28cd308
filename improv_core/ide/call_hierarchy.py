"""Call hierarchy: the definitions and lines that use a name, and the names that a definition or a line uses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from improv_core.ide.document_symbol import OutlineEntry, outline_of
from improv_core.ide.references import names_used, symbol_at
from improv_core.program.analysis import Analysis
from improv_core.text import Span

MAX_CALLS = 1_000
"""The most entries of one answer."""


@dataclass(frozen=True, slots=True)
class HierarchyCall:
    """A definition or a line of robots at the other end of a use, and the spans of the name in the one that uses it."""

    entry: OutlineEntry
    spans: Sequence[Span]


def prepare(analysis: Analysis, offset: int) -> OutlineEntry | None:
    """Return the definition of the name at an offset; on a robot, its line; None if there is neither."""
    symbol = symbol_at(analysis, offset)
    if not symbol or symbol.kind == "parameter":
        return None
    if symbol.kind == "robot":
        line = analysis.statement_at(offset)
        return outline_of(analysis, line.index) if line else None
    return None if symbol.definer is None else outline_of(analysis, symbol.definer)


def incoming(analysis: Analysis, offset: int) -> list[HierarchyCall]:
    """Return the definitions and lines that use the name that is defined at an offset."""
    placed = analysis.statement_at(offset)
    name = placed.statement.defines if placed else None
    users = analysis.bindings.users(name, placed.index) if placed and name else ()
    return [call for user in users[:MAX_CALLS] for call in _calls(analysis, user, user, name)]


def outgoing(analysis: Analysis, offset: int) -> list[HierarchyCall]:
    """Return the definitions that the definition or line at an offset uses, in the order of the text."""
    placed = analysis.statement_at(offset)
    found: list[HierarchyCall] = []
    for name in islice(placed.statement.uses, MAX_CALLS) if placed else ():
        definer = analysis.bindings.definer(name, placed.index) if placed else None
        if placed and definer is not None:
            found += _calls(analysis, definer, placed.index, name)
    return found


def _calls(analysis: Analysis, other: int, user: int, name: str | None) -> Iterator[HierarchyCall]:
    """Yield the use of a name in the statement `user`, seen from the statement at the other end."""
    start = analysis.offsets[user]
    spans = [token.span.shifted(start) for token in names_used(analysis.placed(user)) if token.text == name]
    entry = outline_of(analysis, other)
    if entry and spans:
        yield HierarchyCall(entry, spans)
