"""Refactorings: extract or inline a name or a phrase, unroll or fold a repeat, wrap a movement, dice, and canons.

All keep the dance as it is, unless their titles say otherwise: wrapping in `[ ]` or `slow`, other dice, and `canon`,
after which the robots wait for each other.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import Action
from improv_core.ide.code_action_canon import as_canon
from improv_core.ide.code_action_extract import extract
from improv_core.ide.code_action_inline import inline_definition, inline_use
from improv_core.ide.fragment import Fragment, fragment_at, replaced
from improv_core.program.analysis import Analysis
from improv_core.program.numbers import LONGEST_NUMBER
from improv_core.syntax import nodes
from improv_core.syntax.characters import COMMENT
from improv_core.syntax.lexer import lex
from improv_core.syntax.nodes import Node
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import LINE_END, Span

MAX_TURNS = 32
"""The largest count of a repeat that can be unrolled."""
_COMMENT = re.compile(COMMENT)
_TURNS = frozenset(map(str, range(2, MAX_TURNS + 1)))
LONGEST = 20_000
"""The most characters that an action may write."""


def refactorings(analysis: Analysis, span: Span) -> list[Action]:
    """Return the refactorings of the selected movement, or of the movement at the cursor if the span is empty."""
    found = [*inline_definition(analysis, span), *as_canon(analysis, span)]
    if fragment := fragment_at(analysis, span):
        found += [
            *extract(analysis, fragment),
            *inline_use(analysis, fragment),
            *_unroll(fragment),
            *_fold(fragment),
            *_other_dice(fragment),
            *_wrap(fragment),
        ]
    return [action for action in found if sum(len(edit.text) for edit in action.edits) <= LONGEST]


def _unroll(fragment: Fragment) -> Iterator[Action]:
    node = fragment.nodes[0]
    if not (fragment.is_term and isinstance(node, nodes.Apply) and node.word.text == "repeat" and node.numbers):
        return
    times, source = node.numbers[0].text, fragment.placed.statement.text
    if fragment.is_itemized or _COMMENT.search(source[node.span.start : node.body.span.start]):
        return
    if times not in _TURNS:
        return
    text = source[slice(*node.body.span)]
    inner = node.body.body if isinstance(node.body, nodes.Bracket) and not node.body.squeezes else None
    if inner and not isinstance(inner, nodes.Parallel) and not LINE_END.search(text):
        text = source[slice(*inner.span)]
    turns = " ".join([text] * int(times))
    yield Action("Unroll", "refactor.rewrite", (replaced(fragment, turns if fragment.takes_items else f"({turns})"),))


def _fold(fragment: Fragment) -> Iterator[Action]:
    """Fold repeated items, either selected ones or those around the cursor."""
    items, outside = fragment.nodes, fragment.around
    if len(items) == 1 and isinstance(items[0], nodes.Series):
        items, outside = items[0].items, (*outside, items[0])
    parent = outside[-1] if outside else None
    if not isinstance(parent, nodes.Series) or fragment.of(items, outside).is_counted:
        return
    source = fragment.placed.statement.text
    if len(items) == 1:
        items = _alike(source, parent.items, items[0])
    words = [_words(source, item) for item in items]
    period = next((each for each in range(1, len(items) // 2 + 1) if _repeats(words, each)), None)
    run = fragment.of(items, outside)
    if not period or _COMMENT.search(run.text):
        return
    text = source[items[0].span.start : items[period - 1].span.end]
    times = len(items) // period
    folded = f"repeat {times} {text if period == 1 else f'({text})'}"
    yield Action(f"Fold into repeat {times}", "refactor.rewrite", (replaced(run, folded),))


def _wrap(fragment: Fragment) -> Iterator[Action]:
    if not fragment.may_be_one_term:
        return
    text = fragment.text
    for title, wrapped in (
        ("Wrap in ( )", f"({text})"),
        ("Wrap in [ ]: squeeze the items into the time of one", f"[{text}]"),
        ("Wrap in slow 2: takes twice as long", f"slow 2 {text if fragment.is_term else f'({text})'}"),
    ):
        yield Action(title, "refactor.rewrite", (replaced(fragment, wrapped),))


def _other_dice(fragment: Fragment) -> Iterator[Action]:
    """Change the nearest `seed` around a word of dice, or write one before it."""
    node = fragment.nodes[0]
    if not (isinstance(node, nodes.Apply) and WORDS[node.word.text].throws):
        return
    start = fragment.placed.start
    seed = _nearest_seed((*fragment.around, node))
    if seed is None:
        put = Edit(Span(node.span.start, node.span.start).shifted(start), "seed 1 ")
        yield Action("Other dice: seed 1", "refactor.rewrite", (put,))
    elif seed.text.isdecimal() and len(seed.text) < LONGEST_NUMBER:
        number = str(int(seed.text) + 1)
        yield Action(f"Other dice: seed {number}", "refactor.rewrite", (Edit(seed.span.shifted(start), number),))


def _nearest_seed(outside: Sequence[nodes.Node]) -> nodes.Number | None:
    seeds = (
        node.numbers[0] for node in reversed(outside) if isinstance(node, nodes.Apply) and node.word.text == "seed"
    )
    return next(seeds, None)


def _alike(source: str, items: Sequence[Node], item: Node) -> tuple[Node, ...]:
    """Return the identical items around one, including it."""
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
