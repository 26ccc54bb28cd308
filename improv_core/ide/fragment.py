"""The part of a movement that a refactoring changes: the selected one, or the one at the cursor."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from improv_core.diagnostics import Edit, Severity
from improv_core.ide.cursor import around, cursor
from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

_ITEMIZING = [word.text for word in WORDS.values() if word.of_items]
MAY_ITEMIZE = re.compile(rf"\b(?:{'|'.join(_ITEMIZING)})\b")
"""A word in a program that may count items anywhere in it."""
_WORD = re.compile(r"\w|[^\x00-\x7f]")


@dataclass(frozen=True, slots=True)
class Fragment:
    """A part of a movement: one node or consecutive items of a series, and the nodes around it, outermost first.

    If `is_itemized`, a word such as `accumulate` may count the items here.
    """

    placed: Placed
    nodes: tuple[Node, ...]
    around: tuple[Node, ...]
    is_itemized: bool

    @property
    def span(self) -> Span:
        """The span, counted from the start of the statement, like all spans of nodes."""
        return Span(self.nodes[0].span.start, self.nodes[-1].span.end)

    @property
    def text(self) -> str:
        return self.placed.statement.text[slice(*self.span)]

    @property
    def is_term(self) -> bool:
        return len(self.nodes) == 1 and not isinstance(self.nodes[0], nodes.Series | nodes.Parallel)

    @property
    def may_be_one_term(self) -> bool:
        """True if it can become a single term without changing the meaning: a `[ ]` counts its items."""
        if self.is_term or not self.is_counted:
            return True
        (first, *others) = self.nodes
        return not others and isinstance(first, nodes.Parallel) and all(nodes.items(each) == 1 for each in first.voices)

    @property
    def is_counted(self) -> bool:
        """True if something counts the items here: a `[ ]`, or a word such as `accumulate`."""
        return self.is_itemized or _is_squeezed(self.around)

    @property
    def takes_items(self) -> bool:
        """True if several items can replace the fragment, which is one term."""
        takes_one = self.around and isinstance(
            self.around[-1], nodes.Apply | nodes.Call | nodes.Choice | nodes.PartTerm
        )
        return not (self.is_counted or takes_one)

    @property
    def takes_voices(self) -> bool:
        """True if a `||` can replace the fragment, which is one term."""
        outside = self.around
        return not outside or (isinstance(outside[-1], nodes.Bracket) and not outside[-1].squeezes)

    def of(self, items: tuple[Node, ...], outside: tuple[Node, ...]) -> Fragment:
        """Return a fragment with other items of the same statement."""
        return Fragment(self.placed, items, outside, self.is_itemized)


def fragment_at(analysis: Analysis, span: Span) -> Fragment | None:
    """Return the selected movement, extended to whole items, or the movement at the cursor if the span is empty."""
    placed = analysis.statement_at(span.start)
    body = placed.body if placed else None
    if not placed or not body or is_broken(placed):
        return None
    if span.start == span.end:
        at = cursor(analysis, span.start)
        return _fragment(analysis, placed, at.around) if at and at.node else None
    text = analysis.text[slice(*span)]
    start = span.start + len(text) - len(text.lstrip()) - placed.start
    end = span.start + len(text.rstrip()) - placed.start
    found = around(body, Span(start, max(start, end)))
    if not found:
        return None
    inner = found[-1]
    if isinstance(inner, nodes.Series):
        items = tuple(item for item in inner.items if item.span.start < end and start < item.span.end)
        if items and len(items) < len(inner.items):
            return Fragment(placed, items, found, _is_itemized(analysis, placed, found))
    return _fragment(analysis, placed, found)


def fragment_of(analysis: Analysis, placed: Placed, node: Node) -> Fragment:
    """Return a node of a statement as a fragment."""
    found = around(placed.body, node.span)
    return _fragment(analysis, placed, found[: found.index(node) + 1])


def replaced(fragment: Fragment, text: str) -> Edit:
    """Return the edit that replaces a fragment, with spaces between words that would run together."""
    span, source = fragment.span, fragment.placed.statement.text
    before = " " if _WORD.match(source[span.start - 1 : span.start]) and _WORD.match(text) else ""
    after = " " if _WORD.match(text[-1:]) and _WORD.match(source[span.end : span.end + 1]) else ""
    return Edit(span.shifted(fragment.placed.start), before + text + after)


def is_broken(placed: Placed) -> bool:
    """Return whether the tree differs from the text because the parser inserted or skipped tokens."""
    return any(each.severity is Severity.ERROR for each in placed.statement.diagnostics)


def _fragment(analysis: Analysis, placed: Placed, found: Sequence[Node]) -> Fragment:
    """Return the innermost of these nodes. The name of a phrase stands for its use."""
    *outside, node = found
    if outside and isinstance(outside[-1], nodes.Call) and node is outside[-1].name:
        node = outside.pop()
    return Fragment(placed, (node,), tuple(outside), _is_itemized(analysis, placed, outside))


def _is_squeezed(outside: Sequence[Node]) -> bool:
    """Return whether a `[ ]` counts the items inside these nodes."""
    for node in reversed(outside):
        if not isinstance(node, nodes.Series | nodes.Parallel):
            return isinstance(node, nodes.Bracket) and node.squeezes
    return False


def _is_itemized(analysis: Analysis, placed: Placed, outside: Sequence[Node]) -> bool:
    """Return whether a word may count the items inside these nodes. It sees through parentheses, names, and phrases."""
    for node in reversed(outside):
        if isinstance(node, nodes.Call):
            return bool(MAY_ITEMIZE.search(analysis.text))
        if isinstance(node, nodes.Apply):
            return node.word.text in _ITEMIZING
        if isinstance(node, nodes.Parallel) or (isinstance(node, nodes.Bracket) and node.squeezes):
            return False
    return placed.statement.defines is not None and bool(MAY_ITEMIZE.search(analysis.text))
