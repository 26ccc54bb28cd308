"""Conditions that can't work as they are written, no matter which robots play."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.score.senses import CUE
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Apply, Choice, Condition, Node
from improv_core.text import Span


def conditions(body: Node) -> Iterator[tuple[Apply | Choice, Condition]]:
    """Yield each `until`, `pause`, and `if` with its condition. If a sense is missing, the parser has reported it."""
    for node in nodes.nodes(body):
        if isinstance(node, (Apply, Choice)) and node.condition and node.condition.sense.text:
            yield node, node.condition


def check_conditions(body: Node) -> Iterator[Diagnostic]:
    """Yield diagnostics of conditions that a sense can't answer, and of those that apply to less than they seem to."""
    for node, condition in conditions(body):
        if condition.sense.text == CUE and (node.word.text != "until" or condition.is_negated):
            yield _instant(node.word, condition)
    for each in nodes.nodes(body):
        if not isinstance(each, nodes.Bracket):  # brackets show the intention
            inside = nodes.children(each)
            for place, child in enumerate(inside, 1):
                yield from _short_reach(child, inside[place:] if isinstance(each, nodes.Series) else ())
    yield from _short_reach(body, ())


def _instant(word: Token, condition: Condition) -> Diagnostic:
    message = f"`{CUE}` is true for an instant only: write `until {CUE}`"
    whole = Span(word.start, condition.span.end)
    fixes = replace(f"Change to until {CUE}", whole, f"until {CUE}") if word.text != "if" else ()
    return Diagnostic("instant-sense", condition.span, message, fixes)


def _short_reach(node: Node, following: tuple[Node, ...]) -> Iterator[Diagnostic]:
    """Report an `until` that watches only the one word after it."""
    if not (isinstance(node, Apply) and node.word.text == "until" and isinstance(node.body, nodes.Primitive)):
        return
    alone, start = node.body.word.text, node.body.span.start
    message = f"`until` watches `{alone}` alone, for one beat at most: write `repeat` before it"
    fixes = [Fix("Insert repeat", (Edit(Span(start, start), "repeat "),))]
    if following:
        end = following[-1].span.end
        message += ", or brackets around all that it should watch"
        fixes.append(Fix("Watch all that follows", (Edit(Span(start, start), "("), Edit(Span(end, end), ")"))))
    yield Diagnostic("short-reach", Span(node.word.start, node.body.span.end), message, tuple(fixes))
