"""Refactorings that replace a name or a phrase with its definition, at one use or everywhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import Action
from improv_core.ide.fragment import Fragment, fragment_of, is_broken, replaced
from improv_core.ide.phrases import arguments
from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Number
from improv_core.text import Span

MAX_USES = 200
"""The most uses of a name that can be inlined everywhere."""


def inline_use(analysis: Analysis, fragment: Fragment) -> Iterator[Action]:
    """Inline the name or phrase at the cursor."""
    name = _used(fragment.nodes[0])
    definer = analysis.bindings.definer(name, fragment.placed.index) if name and fragment.is_term else None
    if definer is None or name not in fragment.placed.statement.uses:
        return
    if len(_uses(analysis, definer)) == 1:
        yield from inline_everywhere(analysis, definer)
    elif edit := _inlined(analysis, definer, fragment):
        yield Action(f"Inline {name} here", "refactor.inline", (edit,))


def inline_definition(analysis: Analysis, span: Span) -> Iterator[Action]:
    """Inline the name or phrase whose definition is at the cursor."""
    placed = analysis.statement_at(span.start)
    if placed and placed.statement.defines and placed.statement.heads[0].span.holds(span.start - placed.start):
        yield from inline_everywhere(analysis, placed.index)


def inline_everywhere(analysis: Analysis, definer: int) -> Iterator[Action]:
    """Inline all uses of the name that a statement defines, and remove the definition."""
    uses = _uses(analysis, definer)
    edits = [edit for fragment in uses[:MAX_USES] if (edit := _inlined(analysis, definer, fragment))]
    overlap = any(other.span.start < one.span.end for one, other in pairwise(edits))  # one in an argument of another
    if not uses or len(edits) < len(uses) or overlap:
        return
    placed = analysis.placed(definer)
    gone = Edit(analysis.lines.whole(placed.span), "")
    where = " everywhere" if len(uses) > 1 else ""
    yield Action(
        f"Inline {placed.statement.heads[0].text}{where} and remove the name", "refactor.inline", (gone, *edits)
    )


def _used(node: Node) -> str | None:
    return nodes.use_name(node).text if isinstance(node, nodes.Name | nodes.Call) else None


def _uses(analysis: Analysis, definer: int) -> list[Fragment]:
    """Return the uses of the name that the statement `definer` defines."""
    statement = analysis.statements[definer]
    kind = nodes.Call if statement.parameters else nodes.Name
    users = analysis.bindings.users(statement.defines or "", definer)[: MAX_USES + 1]
    return [
        fragment_of(analysis, placed, node)
        for placed in map(analysis.placed, users)
        if (body := placed.body)
        for node in nodes.nodes(body)
        if isinstance(node, kind) and _used(node) == statement.defines
    ]


def _inlined(analysis: Analysis, definer: int, fragment: Fragment) -> Edit | None:
    """Return the edit that inlines a name; None if names in its definition have another meaning here."""
    source, target = analysis.placed(definer), fragment.placed
    body = source.body
    own = {each.name for each in target.statement.parameters}
    same = all(
        name not in own and analysis.bindings.definer(name, definer) == analysis.bindings.definer(name, target.index)
        for name in source.statement.uses
    )
    if not same or not body or is_broken(source) or is_broken(target):
        return None
    text = _written_out(source, body, fragment)
    if text is None:
        return None
    fits = (
        fragment.takes_items
        if isinstance(body, nodes.Series)
        else not isinstance(body, nodes.Parallel) or fragment.takes_voices
    )
    return replaced(fragment, text if fits else f"({text})")


def _written_out(source: Placed, body: Node, fragment: Fragment) -> str | None:
    """Return the body of a definition with the arguments of a use in it; None if the arguments are wrong."""
    taken, use = source.statement.parameters, fragment.nodes[0]
    given: Mapping[str, Number | Node] = {}
    if isinstance(use, nodes.Call):
        given = {parameter.name: argument for parameter, argument in arguments(use, taken)}
        if len(use.numbers) + len(use.movements) != len(taken):
            return None
    if len(given) != len(taken) or (taken and not fragment.placed.meaning.ok):
        return None
    start, text = body.span.start, source.statement.text[slice(*body.span)]
    for span, put in sorted(_put(body, given, fragment.placed.statement.text), reverse=True):
        text = text[: span.start - start] + put + text[span.end - start :]
    return text


def _put(body: Node, given: Mapping[str, Number | Node], source: str) -> Iterator[tuple[Span, str]]:
    """Yield the parameters in a body, and the text that replaces each."""
    for node in nodes.nodes(body):
        argument = given.get(node.text) if isinstance(node, nodes.Name) else None
        if argument:
            yield node.span, source[slice(*argument.span)]
        for number in nodes.numbers(node):
            for before, token in pairwise((None, *number.tokens)):
                value = given.get(token.text) if token and token.type == "PARAM" else None
                if token and isinstance(value, Number):
                    yield token.span, _divided(value) if before and before.text == "/" else value.text


def _divided(number: Number) -> str:
    """Return a number in the form that it needs after `/`: its factors become divisors, and its divisors factors."""
    return number.text.translate({ord("*"): "/", ord("/"): "*"})
