"""Completion: what may come at the cursor, according to the grammar and the names in scope."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from improv_core.ide.cursor import Before, before
from improv_core.ide.hover import Hover, name_at, robot_at
from improv_core.program.analysis import Analysis
from improv_core.program.reader import Definition
from improv_core.program.timing import in_beats
from improv_core.syntax.derivation import may_come_next
from improv_core.syntax.vocabulary import WORDS, Kind, Word
from improv_core.text import Span

MOST_NAMES = 300
"""If there are more names, only those that match what is typed so far are offered."""
COUNTS = {"beat": ("60", "30", "120"), "repeat": ("2", "3", "4", "8")}
FACTORS = ("2", "3", "3/2")

_NOTHING_AFTER = re.compile(r"\w*[ \t\ufeff]*(?:[)\]|#\r\n]|$)")


@dataclass(frozen=True, slots=True)
class Item:
    """A word to offer. `kind` is keyword, movement, name, robot, plane, or number.

    `snippet` is what to insert if the editor supports snippets and it is more than the word.
    """

    label: str
    kind: str
    detail: str = ""
    snippet: str = ""


@dataclass(frozen=True, slots=True)
class Completion:
    """The words that can replace the text at `span`, best first.

    `statement` is the index of the statement being written, which determines what names stand for. `whole` is false if
    some names were left out.
    """

    span: Span
    items: Sequence[Item]
    statement: int
    whole: bool


def complete(analysis: Analysis, offset: int) -> Completion | None:
    """The words that may come at the cursor; None in comments and in numbers."""
    found = before(analysis, offset)
    if not found or found.in_number:
        return None
    names: list[Definition] = []
    sign = next((place for place, token in enumerate(found.tokens) if token.type in ("EQUAL", "DOLLAR")), None)
    if sign is None:
        others = list(_heads(analysis, found))
    else:
        accepted = may_come_next(["HEAD"] * sign + [token.type for token in found.tokens[sign:]])
        others = list(_words(accepted, found, bare=not _NOTHING_AFTER.match(analysis.text, offset)))
        if "NAME" in accepted:
            names = list(_names(analysis, found.statement))
    whole = len(names) <= MOST_NAMES
    if not whole:
        letters = found.begun.lower()
        names = list(islice((each for each in names if _fits(each.name.lower(), letters)), MOST_NAMES))
    span = Span(offset - len(found.begun), offset)
    offered = (Item(each.name, "name", in_beats(each.movement.duration)) for each in names)
    return Completion(span, [*offered, *others], found.statement, whole)


def document(analysis: Analysis, item: Item, statement: int, pictures: bool) -> Hover | None:
    """The documentation of a word that is offered in a statement, made when a person looks at it."""
    if item.kind == "name":
        return name_at(analysis, item.label, min(statement, len(analysis.statements) - 1), pictures)
    if item.kind == "robot":
        return robot_at(analysis, item.label, pictures)
    word = WORDS.get(item.label)
    return Hover(Span(0, 0), word.usage, f": {word.about}") if word else None


def _heads(analysis: Analysis, found: Before) -> Iterator[Item]:
    """The words that a statement may start with, and more robots if it starts with robots."""
    heads = [token.text for token in found.tokens]
    if heads == ["beat"]:
        yield from _numbers(COUNTS["beat"], "beats per minute")
        return
    if not heads:
        yield Item("beat", "keyword", WORDS["beat"].about, "beat ${1:60}")
    if all(token.type == "NAME" for token in found.tokens):
        plays = analysis.robots
        for robot in dict.fromkeys([*analysis.cast.robots, *plays]):
            if robot not in heads:
                yield Item(robot, "robot", in_beats(plays[robot].duration) if robot in plays else "in improv.toml")


def _words(accepted: frozenset[str], found: Before, bare: bool) -> Iterator[Item]:
    """The words of these terminals; `bare` if what they apply to already follows the cursor."""
    for word in WORDS.values():
        if word.kind.value in accepted and word.kind is not Kind.BEAT:
            kind = {Kind.PRIMITIVE: "movement", Kind.PLANE: "plane"}.get(word.kind, "keyword")
            yield Item(word.text, kind, word.about, _snippet(word, bare))
    if "NUMBER" in accepted and found.tokens:
        last = found.tokens[-1].text
        yield from _numbers(COUNTS.get(last, FACTORS), "times" if last == "repeat" else "factor")


def _numbers(values: Sequence[str], detail: str) -> Iterator[Item]:
    return (Item(value, "number", detail) for value in values)


def _snippet(word: Word, bare: bool) -> str:
    argument = {
        Kind.REPEAT: " ${1:4}",
        Kind.FACTOR: " ${1:2}",
        Kind.REFLECT: " ${1|YZ,XZ,XY|}",
        Kind.RAMP: " ${1:1} ${2:2}",
        Kind.PLAIN: "",
    }.get(word.kind)
    if argument is None or (bare and not argument):
        return ""
    return f"{word.text}{argument}" if bare else f"{word.text}{argument} ($0)"


def _names(analysis: Analysis, before: int) -> Iterable[Definition]:
    """The names in scope of a statement, the nearest first."""
    found: dict[str, Definition] = {}
    for meaning in reversed(analysis.meanings[:before]):
        if definition := meaning.definition:
            found.setdefault(definition.name, definition)
    return found.values()


def _fits(name: str, letters: str) -> bool:
    rest = iter(name)
    return all(letter in rest for letter in letters)
