"""Fixes in several places: arguments that match the head of their phrase, and `canon` in the lines of robots."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from improv_core.diagnostics import Edit, Fix, replace
from improv_core.program.definitions import Phrase
from improv_core.syntax import nodes
from improv_core.text import Span

NUMBER, MOVEMENT = " 2", " rest"
"""Texts that a fix inserts for missing arguments. The movement keeps the robot still."""


def give_arguments(use: nodes.Name | nodes.Call, phrase: Phrase, declared: Span) -> tuple[Fix, ...]:
    """Return the fix for a use with too few or too many arguments. `declared` is the span of its parameters."""
    name = nodes.use_name(use)
    numbers, movements = (use.numbers, use.movements) if isinstance(use, nodes.Call) else ((), ())
    spare, lacking = numbers[len(phrase.numbers) :], len(phrase.movements) - len(movements)
    last = numbers[-1].span.end if numbers else name.span.end
    if spare and lacking:
        first, *others = (each.name for each in phrase.movements)
        head = " ".join([*(each.name for each in phrase.numbers), first, *(f"({each})" for each in others)])
        return replace(f"Change {first} in the head", declared, f" {head} ")
    if spare:
        return ()
    end = movements[-1].span.end if movements else last
    given = {last: NUMBER * (len(phrase.numbers) - len(numbers))}
    given[end] = given.get(end, "") + MOVEMENT * lacking
    edits = tuple(Edit(Span(place, place), text) for place, text in given.items() if text)
    return (Fix(f"Insert {''.join(given.values()).strip()}", edits, guess=True),)


def move_canon(canon: nodes.Apply, text: str, uses: Sequence[int] | None) -> Iterable[Fix]:
    """Yield the fixes for a `canon` in a definition. `text` is that of its statement, and `uses` are the places of the
    name in lines of robots; None if it can't be moved there."""
    gone = Edit(Span(canon.span.start, canon.body.span.start), "")
    if uses:
        written = text[slice(*gone.span)]
        yield Fix("Move it to the lines of robots", (gone, *(Edit(Span(place, place), written) for place in uses)))
    yield Fix("Remove it", (gone,), guess=True)
