"""Refactorings that give a movement a name, also as a phrase with a number as its parameter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import Action
from improv_core.ide.fragment import Fragment, replaced
from improv_core.ide.phrases import label
from improv_core.program.analysis import Analysis
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import Parameter
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import LINE_END, Span, free_name

_LETTERS = ("n", "k", "a", "b", "c", "d")
"""Names for a parameter that is a number, the best first."""


def extract(analysis: Analysis, fragment: Fragment) -> Iterator[Action]:
    """Yield actions that write a definition on the line above, where all names have the same meaning."""
    first = fragment.nodes[0]
    if not fragment.may_be_one_term or (fragment.is_term and isinstance(first, nodes.Name)):
        return
    if any(isinstance(node, nodes.Apply) and WORDS[node.word.text].by_robot for node in _inside(fragment)):
        return  # only a line with robots can hold one
    own = [each for each in fragment.placed.statement.parameters if each.name in _own_names(fragment)]
    name = _fresh_name(analysis, fragment)
    given = [each.name for each in own]
    yield _action("Extract to a name", analysis, fragment, fragment.text, name, own, given)
    number = next((token for each in _inside(fragment) for token in _literals(each)), None)
    letter = _letter(fragment)
    if not number or not letter or isinstance(first, nodes.Call):
        return
    text = fragment.text
    for token in sorted(
        (token for node in _inside(fragment) for token in _literals(node) if token.text == number.text),
        key=lambda token: -token.start,
    ):
        start, end = token.span.shifted(-fragment.span.start)
        text = text[:start] + letter + text[end:]
    taken = [Parameter(number._replace(text=letter), True), *own]
    yield _action("Extract to a phrase", analysis, fragment, text, name, taken, [number.text, *given])


def _action(
    title: str,
    analysis: Analysis,
    fragment: Fragment,
    text: str,
    name: str,
    taken: Sequence[Parameter],
    given: Sequence[str],
) -> Action:
    """Return the action that defines a name with these parameters above, and uses it with these arguments."""
    start, lines = fragment.placed.start, analysis.lines
    if LINE_END.search(text) and not (fragment.is_term and isinstance(fragment.nodes[0], nodes.Bracket)):
        text = f"({text})"
    indent = analysis.text[lines.start(lines.position(start).line) : start].strip("\ufeff")
    line_end = LINE_END.search(analysis.text)
    head, _ = label(name, taken)
    definition = Edit(Span(start, start), f"{head} = {text}{line_end[0] if line_end else chr(10)}{indent}")
    use = replaced(fragment, " ".join([name, *given]))
    return Action(f"{title}: {head}", "refactor.extract", (definition, use))


def _inside(fragment: Fragment) -> Iterator[nodes.Node]:
    return (node for each in fragment.nodes for node in nodes.nodes(each))


def _literals(node: nodes.Node) -> Iterator[Token]:
    pairs = (pair for number in nodes.numbers(node) for pair in pairwise((*number.tokens, None)))
    return (one for one, other in pairs if one and one.type == "NUMBER" and not (other and other.type == "UNIT"))


def _own_names(fragment: Fragment) -> set[str]:
    """Return the names in a fragment that may be parameters of its statement."""
    found = {node.text for node in _inside(fragment) if isinstance(node, nodes.Name)}
    return found | {
        token.text for node in _inside(fragment) for number in nodes.numbers(node) for token in number.parameters
    }


def _letter(fragment: Fragment) -> str | None:
    """Return a name for a parameter that has no other meaning in the statement."""
    statement = fragment.placed.statement
    taken = {*statement.uses, *(each.name for each in statement.parameters)}
    return next((letter for letter in _LETTERS if letter not in taken), None)


def _fresh_name(analysis: Analysis, fragment: Fragment) -> str:
    """Return a name made of the movement's words if they are few, otherwise `phrase`; with a number if that is
    taken."""
    own = {each.name for each in fragment.placed.statement.parameters}
    named = (token.text for token in lex(fragment.text) if token.text in WORDS or token.type == "NAME")
    words = [word for word in named if word not in own]
    stem = "_".join(words) if 2 <= len(words) <= 3 else f"my_{words[0]}" if len(words) == 1 else "phrase"
    if len(stem) > 40:
        stem = "phrase"
    parameters = (each.name for statement in analysis.statements for each in statement.parameters)
    taken = {*WORDS, *analysis.bindings.defined, *analysis.bindings.used, *parameters}
    return free_name(stem, taken)
