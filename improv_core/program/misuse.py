"""Diagnostics and fixes for words around movements to which they can't apply, or on which they have no effect, for
poses that no body part reaches, for conditions that can't work as they are written, and for wrong arguments of phrases.

Spans count from the start of the statement. `movement_of` returns the movement of a node.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from typing import TypeGuard

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.program.definitions import Phrase
from improv_core.program.timing import in_beats
from improv_core.score.algebra import FromStatement, Series
from improv_core.score.movement import ENDLESS, Movement
from improv_core.score.reactions import Condition as Reacts
from improv_core.score.reactions import Until
from improv_core.score.senses import BUMP, CUE, NEAR
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Apply, Call, Choice, Condition, Name, Node
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

MAX_LENGTHS = 3
"""The most different lengths of the items of a choice that a message lists."""
TURNS = 4
"""The number of turns that a fix gives to a `repeat` that must end."""

MovementOf = Callable[[Node], Movement]


def endless(node: nodes.Apply, movement_of: MovementOf) -> Diagnostic:
    """Return the diagnostic about a word that needs a movement that ends, around one that never does."""
    word = node.word.text
    repeat = next((each for each in nodes.nodes(node.body) if _is_endless_repeat(each)), None)
    fixes = replace(f"Change to repeat {TURNS}", repeat.word.span, f"repeat {TURNS}", guess=True) if repeat else ()
    if WORDS[word].backward:
        message = f"`{word}` needs a movement that ends: give the `repeat` in it a number"
        return Diagnostic("endless-reverse", node.word.span, message, fixes)
    cause = _endless_word(node.body, movement_of)
    what = f"give `{cause}` a number" if cause == "repeat" else f"`{cause}` never ends"
    return Diagnostic("open-length", node.word.span, f"`{word}` needs a movement that ends: {what}", fixes)


def open_length(node: nodes.Apply, movement_of: MovementOf) -> Diagnostic:
    """Return the diagnostic about a word that needs a fixed length, around a movement whose length senses decide."""
    word, body = node.word.text, node.body
    cause = _open_word(body, movement_of)
    of_items = WORDS[word].of_items
    advice = "choose among others" if of_items else f"move `{word}` inside `{cause}`"
    message = f"`{word}` needs a fixed length, but senses decide how long `{cause}` lasts: {advice}"
    fixes: tuple[Fix, ...] = ()
    guarded = body.body if isinstance(body, nodes.Apply) and body.condition else None
    if guarded and not of_items and not movement_of(guarded).open:
        there = guarded.span.start
        edits = (Edit(Span(node.span.start, body.span.start), ""), Edit(Span(there, there), f"{written(node)} "))
        fixes = (Fix(f"Move {word} inside {cause}", edits),)
    return Diagnostic("open-length", node.word.span, message, fixes)


def pose_reversed(node: nodes.Apply) -> Diagnostic:
    """Return the diagnostic about a word around a pose, whose path depends on the joints' positions when it begins."""
    word = f"{node.word.text} {node.across.text}" if node.across else node.word.text
    message = f"`{word}` can't change a pose, which is reached from wherever its joints are: move `to` out of it"
    return Diagnostic("pose-reversed", node.word.span, message)


def uneven(node: nodes.Apply, here: Sequence[Node], items: Sequence[Movement]) -> Diagnostic:
    """Return the diagnostic about a choice among items of different lengths; `here` are those written inside it."""
    lengths = list(dict.fromkeys(in_beats(item.duration) for item in items))
    shown = ", ".join(lengths[:MAX_LENGTHS]) + (", …" if len(lengths) > MAX_LENGTHS else "")
    message = f"the items of `choose` differ in length ({shown}): give them one length with `fit`"
    first = items[0].duration
    fixes: tuple[Fix, ...] = ()
    if len(here) == len(items) and all(0 < item.duration < ENDLESS for item in items):
        others = [each for each, item in zip(here, items, strict=True) if item.duration != first]
        text = f"fit {Fraction(first)} "
        edits = tuple([Edit(Span(each.span.start, each.span.start), text) for each in others])
        fixes = (Fix(f"Fit the others into {in_beats(first)}", edits),)
    return Diagnostic("uneven-choice", node.word.span, message, fixes)


def without_effect(node: nodes.Apply, message: str, *, safe: bool = True) -> Diagnostic:
    """Return the diagnostic about a word without effect, with the fix that removes it and its numbers."""
    span = Span(node.word.start, node.numbers[-1].span.end if node.numbers else node.word.end)
    return Diagnostic("no-effect", span, message, replace("Remove it", span, "", safe=safe))


STALLS = "it stands here until what is near goes away: to turn away, turn outside `until`: {example}"
EXAMPLE = "`repeat (until {sense} (repeat forward) left)`"


def may_stall(node: nodes.Apply, body: Movement) -> Diagnostic | None:
    """Return the diagnostic about an endless `repeat` of nothing but `until near` or `until bump`: once that holds, no
    movement begins that could change it."""
    if not _is_endless_repeat(node):
        return None
    found, seen, waiting = set[Reacts](), set[int](), [body]
    while waiting:
        part = waiting.pop()
        if id(part) in seen:
            continue
        seen.add(id(part))
        if isinstance(part, Until):
            found.add(part.condition)
        elif isinstance(part, Series | FromStatement):
            waiting += part.parts
        else:
            return None
    if len(found) > 1 or not all(each.wanted and each.sense in (NEAR, BUMP) for each in found):
        return None
    (condition,) = found
    message = STALLS.format(example=EXAMPLE.format(sense=condition.sense))
    return Diagnostic("may-stall", node.word.span, message)


def written(node: nodes.Apply) -> str:
    """Return a word with its numbers: `repeat 4`."""
    return " ".join([node.word.text, *(each.text for each in node.numbers)])


def _is_endless_repeat(node: Node) -> TypeGuard[nodes.Apply]:
    return isinstance(node, nodes.Apply) and node.word.text == "repeat" and not node.numbers


def _endless_word(body: Node, movement_of: MovementOf) -> str:
    """Return the word, or the name, that makes a movement endless."""
    for node in nodes.nodes(body):
        if _is_endless_repeat(node):
            return "repeat"
        if isinstance(node, (Name, Call)) and movement_of(node).duration == ENDLESS:
            return nodes.use_name(node).text
    return "repeat"


def _open_word(body: Node, movement_of: MovementOf) -> str:
    """Return the word, or the name, by which senses decide the length of a movement."""
    for node in nodes.nodes(body):
        if isinstance(node, nodes.Choice) or (isinstance(node, nodes.Apply) and node.condition):
            return node.word.text
        if isinstance(node, (Name, Call)) and movement_of(node).open:
            return nodes.use_name(node).text
    return "until"


def misplaced_poses(body: Node, movement_of: MovementOf) -> Iterator[Diagnostic]:
    """Report the poses, and the uses of names with poses, that no word for a body part contains."""
    if isinstance(body, nodes.PoseTerm):
        pose = f"{body.word.text} {body.pose.text}"
        yield _misplaced(body, f"only body parts reach poses: write one before `{pose}`, such as `head {pose}`")
    elif isinstance(body, nodes.Name | nodes.Call):
        if poses := movement_of(body).body_words.loose_poses:
            arguments = body.movements if isinstance(body, nodes.Call) else ()
            found = [each for argument in arguments for each in misplaced_poses(argument, movement_of)]
            name = nodes.use_name(body)
            message = f"`{name.text}` reaches the pose `{poses[0]}`: write a body part before it"
            yield from found or [_misplaced(name, message)]
    elif not isinstance(body, nodes.PartTerm):
        for child in nodes.children(body):
            yield from misplaced_poses(child, movement_of)


def _misplaced(node: Node, message: str) -> Diagnostic:
    return Diagnostic("misplaced-pose", node.span, message)


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
    if not (
        isinstance(node, Apply)
        and node.word.text == "until"
        and isinstance(node.body, nodes.Primitive | nodes.MeasuredWord)
    ):
        return
    alone, start = node.body.word.text, node.body.span.start
    message = f"`until` watches `{alone}` alone, for one beat at most: write `repeat` before it"
    fixes = [Fix("Insert repeat", (Edit(Span(start, start), "repeat "),))]
    if following:
        end = following[-1].span.end
        message += ", or brackets around all that it should watch"
        fixes.append(Fix("Watch all that follows", (Edit(Span(start, start), "("), Edit(Span(end, end), ")"))))
    yield Diagnostic("short-reach", Span(node.word.start, node.body.span.end), message, tuple(fixes))


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
