"""Refactorings: extract a movement as a name, inline a name, unroll or fold a repeat, and wrap a movement.

All except wrapping in `[ ]` or `slow`, whose titles say so, keep what the program plays.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from improv_core.diagnostics import Edit, Severity
from improv_core.ide.code_action import Action
from improv_core.ide.cursor import around, cursor
from improv_core.program.analysis import Analysis, Placed
from improv_core.program.numbers import value_of
from improv_core.syntax import nodes
from improv_core.syntax.lexer import lex
from improv_core.syntax.nodes import Node
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import LINE_END, Span

MOST_TURNS = 32
"""The largest count of a repeat that can be unrolled."""
MOST_USES = 200
"""The most uses of a name that can be inlined everywhere."""
LONGEST = 20_000
"""The most characters that an action may write."""

_WORD = re.compile(r"\w")
_SPACES = " \t\r\n"


def refactorings(analysis: Analysis, span: Span) -> list[Action]:
    """The refactorings of the selected movement, or of the movement at the cursor if the span is empty."""
    found = [*_inline_definition(analysis, span)]
    if piece := _piece(analysis, span):
        found += [
            *_extract(analysis, piece),
            *_inline_use(analysis, piece),
            *_unroll(piece),
            *_fold(piece),
            *_wrap(piece),
        ]
    return [action for action in found if sum(len(edit.text) for edit in action.edits) <= LONGEST]


@dataclass(frozen=True, slots=True)
class _Piece:
    """A part of a movement: one node or consecutive items of a series, and the nodes around it, outermost first."""

    placed: Placed
    nodes: tuple[Node, ...]
    around: tuple[Node, ...]

    @property
    def span(self) -> Span:
        """Counts from the start of the statement, like all spans of nodes."""
        return Span(self.nodes[0].span.start, self.nodes[-1].span.end)

    @property
    def text(self) -> str:
        return self.placed.statement.text[slice(*self.span)]

    @property
    def is_term(self) -> bool:
        return len(self.nodes) == 1 and not isinstance(self.nodes[0], nodes.Series | nodes.Parallel)

    @property
    def may_be_one_term(self) -> bool:
        """Whether it can become a single term without changing the meaning: a `[ ]` counts its items."""
        if self.is_term or not _counted(self.around):
            return True
        (first, *others) = self.nodes
        return not others and isinstance(first, nodes.Parallel) and all(nodes.items(each) == 1 for each in first.voices)


def _piece(analysis: Analysis, span: Span) -> _Piece | None:
    placed = analysis.statement_at(span.start)
    if not placed or not placed.statement.body or _is_broken(placed):
        return None
    if span.start == span.end:
        at = cursor(analysis, span.start)
        return _Piece(placed, at.around[-1:], at.around[:-1]) if at and at.node else None
    text = analysis.text[slice(*span)]
    start = span.start + len(text) - len(text.lstrip(_SPACES)) - placed.start
    end = span.start + len(text.rstrip(_SPACES)) - placed.start
    found = around(placed.statement.body, Span(start, max(start, end)))
    if not found:
        return None
    inner = found[-1]
    if isinstance(inner, nodes.Series):
        items = tuple(item for item in inner.items if item.span.start < end and start < item.span.end)
        if items and len(items) < len(inner.items):
            return _Piece(placed, items, found)
    return _Piece(placed, (inner,), found[:-1])


def _extract(analysis: Analysis, piece: _Piece) -> Iterator[Action]:
    """The definition goes on the line above, where all names have the same meaning."""
    first = piece.nodes[0]
    if not piece.may_be_one_term or (piece.is_term and isinstance(first, nodes.Name)):
        return
    name, text, start = _fresh_name(analysis, piece.text), piece.text, piece.placed.start
    if LINE_END.search(text) and not (piece.is_term and isinstance(first, nodes.Bracket)):
        text = f"({text})"
    lines = analysis.lines
    indent = analysis.text[lines.start(lines.position(start).line) : start].strip("\ufeff")
    line_end = LINE_END.search(analysis.text)
    definition = Edit(Span(start, start), f"{name} = {text}{line_end[0] if line_end else chr(10)}{indent}")
    yield Action(f"Extract to a name: {name}", "refactor.extract", (definition, _replace(piece, name)))


def _inline_use(analysis: Analysis, piece: _Piece) -> Iterator[Action]:
    node = piece.nodes[0]
    if not (piece.is_term and isinstance(node, nodes.Name)):
        return
    definer = analysis.bindings.definer(node.text, piece.placed.index)
    if definer is None:
        return
    if len(_uses(analysis, definer)) == 1:
        yield from _inline_everywhere(analysis, definer)
    elif edit := _inlined(analysis, definer, piece):
        yield Action(f"Inline {node.text} here", "refactor.inline", (edit,))


def _inline_definition(analysis: Analysis, span: Span) -> Iterator[Action]:
    placed = analysis.statement_at(span.start)
    if placed and placed.statement.defines and placed.statement.heads[0].span.holds(span.start - placed.start):
        yield from _inline_everywhere(analysis, placed.index)


def _inline_everywhere(analysis: Analysis, definer: int) -> Iterator[Action]:
    uses = _uses(analysis, definer)
    edits = [_inlined(analysis, definer, piece) for piece in uses[:MOST_USES]]
    whole = [edit for edit in edits if edit]
    if not uses or len(whole) < len(uses):
        return
    start, statement = analysis.offsets[definer], analysis.statements[definer]
    first, last = (analysis.lines.position(place).line for place in (start, start + len(statement.text)))
    gone = Edit(Span(analysis.lines.start(first), analysis.lines.start(last + 1)), "")
    title = f"Inline {statement.heads[0].text}" + (" everywhere" if len(uses) > 1 else "") + " and remove the name"
    yield Action(title, "refactor.inline", (gone, *whole))


def _uses(analysis: Analysis, definer: int) -> list[_Piece]:
    """The uses of the name that the statement `definer` defines."""
    name = analysis.statements[definer].defines
    placed = [analysis.placed(index) for index in analysis.bindings.users(name or "", definer)[: MOST_USES + 1]]
    return [
        _Piece(each, (node,), around(each.statement.body, node.span)[:-1])
        for each in placed
        if each.statement.body
        for node in nodes.names(each.statement.body)
        if node.text == name
    ]


def _inlined(analysis: Analysis, definer: int, piece: _Piece) -> Edit | None:
    """The edit that inlines a name; None if names in its definition mean something else here."""
    source = analysis.placed(definer)
    body = source.statement.body
    same = all(
        analysis.bindings.definer(name, definer) == analysis.bindings.definer(name, piece.placed.index)
        for name in source.statement.uses
    )
    if not same or not body or _is_broken(source) or _is_broken(piece.placed):
        return None
    text = source.statement.text[slice(*body.span)]
    fits = (
        _takes_items(piece.around)
        if isinstance(body, nodes.Series)
        else not isinstance(body, nodes.Parallel) or _takes_voices(piece.around)
    )
    return _replace(piece, text if fits else f"({text})")


def _unroll(piece: _Piece) -> Iterator[Action]:
    node = piece.nodes[0]
    if not (piece.is_term and isinstance(node, nodes.Apply) and node.word.text == "repeat" and node.numbers):
        return
    times = value_of(node.numbers[0].text)
    source = piece.placed.statement.text
    if (
        isinstance(times, str)
        or times not in range(2, MOST_TURNS + 1)
        or "#" in source[node.span.start : node.body.span.start]
    ):
        return
    text = source[slice(*node.body.span)]
    inner = node.body.body if isinstance(node.body, nodes.Bracket) and not node.body.squeezes else None
    if inner and not isinstance(inner, nodes.Parallel) and not LINE_END.search(text):
        text = source[slice(*inner.span)]
    turns = " ".join([text] * int(times))
    yield Action(
        "Unroll", "refactor.rewrite", (_replace(piece, turns if _takes_items(piece.around) else f"({turns})"),)
    )


def _fold(piece: _Piece) -> Iterator[Action]:
    """Fold repeated items, either selected ones or those around the cursor."""
    items, outside = piece.nodes, piece.around
    if len(items) == 1 and isinstance(items[0], nodes.Series):
        items, outside = items[0].items, (*outside, items[0])
    parent = outside[-1] if outside else None
    if not isinstance(parent, nodes.Series) or _counted(outside):
        return
    source = piece.placed.statement.text
    if len(items) == 1:
        items = _alike(source, parent.items, items[0])
    words = [_words(source, item) for item in items]
    period = next((each for each in range(1, len(items) // 2 + 1) if _repeats(words, each)), None)
    run = _Piece(piece.placed, items, outside)
    if not period or "#" in run.text:
        return
    text = source[items[0].span.start : items[period - 1].span.end]
    times = len(items) // period
    folded = f"repeat {times} {text if period == 1 else f'({text})'}"
    yield Action(f"Fold into repeat {times}", "refactor.rewrite", (_replace(run, folded),))


def _wrap(piece: _Piece) -> Iterator[Action]:
    if not piece.may_be_one_term:
        return
    text = piece.text
    for title, wrapped in (
        ("Wrap in ( )", f"({text})"),
        ("Wrap in [ ]: squeeze the items into the time of one", f"[{text}]"),
        ("Wrap in slow 2: takes twice as long", f"slow 2 {text if piece.is_term else f'({text})'}"),
    ):
        yield Action(title, "refactor.rewrite", (_replace(piece, wrapped),))


def _takes_items(outside: Sequence[Node]) -> bool:
    """Whether several items can replace one term here."""
    return not _counted(outside) and not (outside and isinstance(outside[-1], nodes.Apply))


def _takes_voices(outside: Sequence[Node]) -> bool:
    """Whether a `||` can replace one term here."""
    return not outside or (isinstance(outside[-1], nodes.Bracket) and not outside[-1].squeezes)


def _counted(outside: Sequence[Node]) -> bool:
    """Whether a `[ ]` counts the items inside these nodes."""
    for node in reversed(outside):
        if not isinstance(node, nodes.Series | nodes.Parallel):
            return isinstance(node, nodes.Bracket) and node.squeezes
    return False


def _replace(piece: _Piece, text: str) -> Edit:
    """The edit that replaces a piece, with spaces where words would run together."""
    span, source = piece.span, piece.placed.statement.text
    before = " " if _WORD.match(source[span.start - 1 : span.start]) and _WORD.match(text) else ""
    after = " " if _WORD.match(text[-1:]) and _WORD.match(source[span.end : span.end + 1]) else ""
    return Edit(span.shifted(piece.placed.start), before + text + after)


def _alike(source: str, items: Sequence[Node], item: Node) -> tuple[Node, ...]:
    """The identical items around one, including it."""
    words = [_words(source, each) for each in items]
    first = last = next(place for place, each in enumerate(items) if each is item)
    while first and words[first - 1] == words[last]:
        first -= 1
    while last + 1 < len(items) and words[last + 1] == words[first]:
        last += 1
    return tuple(items[first : last + 1])


def _repeats(words: Sequence[Sequence[str]], period: int) -> bool:
    turns = [words[place : place + period] for place in range(0, len(words), period)]
    return all(one == other for one, other in pairwise(turns))


def _words(source: str, node: Node) -> list[str]:
    return [token.text for token in lex(source[slice(*node.span)])]


def _is_broken(placed: Placed) -> bool:
    """Whether the tree differs from the text because the parser inserted or skipped tokens."""
    return any(each.severity is Severity.ERROR for each in placed.statement.diagnostics)


def _fresh_name(analysis: Analysis, text: str) -> str:
    """A name made of the movement's own words if they are few, otherwise `phrase`; with a number if that is taken."""
    words = [token.text for token in lex(text) if token.text in WORDS or token.type == "NAME"]
    stem = "_".join(words) if 2 <= len(words) <= 3 else f"my_{words[0]}" if len(words) == 1 else "phrase"
    if len(stem) > 40:
        stem = "phrase"
    taken = {*WORDS, *analysis.bindings.defined, *analysis.bindings.used}
    name, number = stem, 1
    while name in taken:
        number += 1
        name = f"{stem}_{number}"
    return name
