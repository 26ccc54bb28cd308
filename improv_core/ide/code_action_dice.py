"""A code action that throws other dice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import Action
from improv_core.ide.fragment import Fragment
from improv_core.program.numbers import LONGEST_NUMBER
from improv_core.syntax import nodes
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span


def other_dice(fragment: Fragment) -> Iterator[Action]:
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
