"""Semantic tokens: color words by their meaning, whereas a grammar only sees their form."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from typing import NamedTuple, TypeAlias

from improv_core.ide.body_words import takes
from improv_core.ide.semantic_tokens_legend import MODIFIERS, TYPES
from improv_core.program.analysis import Analysis
from improv_core.program.definitions import TO
from improv_core.slices import in_slices
from improv_core.syntax.characters import COMMENT, HASHES, NAME, shape, spelled
from improv_core.syntax.lexer import NUMBER
from improv_core.syntax.nodes import OfKind, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.vocabulary import TRANSFORMERS, WORDS, of_kind
from improv_core.syntax.word import Kind

_COMMENT = re.compile(COMMENT)
_HASH = re.compile(rf"[{HASHES}]")
_WORD = re.compile(rf"({_COMMENT.pattern})|({NAME})|({NUMBER})|\|\||-{{3,}}|[=$*/]")


Colored: TypeAlias = tuple[int, int, int, int]
"""The start and end of a word, counted from the start of its fragment, and its type and modifiers (one bit each),
numbered as in the legend."""


class Uncolored(NamedTuple):
    """A statement or a comment line, with all that decides its colors.

    `unknown` are the undefined names in it, and `strange` the unknown robots and senses: these get no color.
    `body_words` are the names that are words of robots' bodies. If it `hides_radius`, that is a name in it.
    """

    text: str
    unknown: tuple[str, ...] = ()
    strange: tuple[str, ...] = ()
    body_words: tuple[str, ...] = ()
    hides_radius: bool = False


def fragments(analysis: Analysis, first: int = 0, last: int | None = None) -> Iterator[tuple[int, Uncolored]]:
    """Yield the fragments of a program that touch the text between two offsets, in order, each with its offset."""
    text, place = analysis.text, 0
    stop = len(text) if last is None else last
    suspects = analysis.unusual.faulty.union(analysis.infeasible)  # in all others, all names and robots are known
    for index, start in enumerate(analysis.offsets):
        if _HASH.search(text, place, start):
            yield from _comment_lines(text, place, start, first, stop)
        if start > stop:
            return
        statement = analysis.statements[index]
        place = start + len(statement.text)
        if place >= first:
            unknown, strange = _unknown(analysis, index) if index in suspects else ((), ())
            hides_radius = analysis.meanings[index].statement is not statement
            yield start, Uncolored(statement.text, unknown, strange, _body_words(analysis, index), hides_radius)
    yield from _comment_lines(text, place, len(text), first, stop)


def colored(fragment: Uncolored) -> list[Colored]:
    """Return the colored words of a fragment, in order. They depend only on it, so they can be cached.

    Does not use the lexer: a document may have thousands of words when it is opened, and only colors are needed.
    """
    text, unknown, strange, body_words, hides_radius = fragment
    sign, heads, parameters = None, set[tuple[int, int]](), dict[str, tuple[int, int]]()
    opening: dict[int, tuple[int, tuple[int, int] | None]] = {}
    if not text.startswith(tuple(HASHES)):
        statement = parse_statement(text)
        statement = statement.as_names if hides_radius and statement.as_names else statement
        sign = statement.sign
        heads = {(head.start, head.end) for head in statement.heads if head.text not in strange}
        parameters = {each.name: each.token.span for each in statement.parameters}
        opening = dict(_words(statement, strange))
    head = _DEFINITION if sign and sign.type == "EQUAL" else _ROBOT
    named = sign.start if sign and sign.type != "BEAT" else 0  # before this offset, names are definitions or robots
    found = []
    before, whole = "", 0  # up to this offset, all is one word
    is_plain = text.isascii()
    for match in in_slices(_WORD.finditer(text if is_plain else shape(text))):
        word = match[0] if is_plain else spelled(text[match.start() : match.end()])
        if match.start() in opening:
            whole, known = opening[match.start()]
            if known:
                found.append((match.start(), whole, *known))
        if match.start() < whole:
            continue
        kind = _KINDS.get(word) or _KINDS_BY_FORM[match.lastindex or 0]
        start, end = match.span()
        if kind is _USE:
            if word in parameters and (start >= named or (start, end) == parameters[word]):
                kind = _PARAMETER if start >= named else _DECLARATION
            elif start < named:
                if (start, end) not in heads:  # only part of a name, as in `my-robot`
                    continue
                kind = head
            elif before in _BEFORE_SENSES:
                if word in strange:
                    continue
                kind = _SENSE
            elif before == TO and TO in body_words:
                kind = _POSE
            elif word in unknown:
                continue
            elif word in body_words:
                kind = _BODY_WORD
        found.append((start, end, kind[0], kind[1]))
        if kind is not _COMMENT_KIND:
            before = word
    return found


def _words(statement: Statement, strange: Container[str]) -> Iterator[tuple[int, tuple[int, tuple[int, int] | None]]]:
    """Yield the start of each word that is a name elsewhere, its end, and its kind, if it has a color."""
    for word in statement.words:
        yield word.start, (word.end, _UNIT if word.type == "UNIT" else _KEYWORD)
    if isinstance(statement.opening, OfKind):
        profile = statement.opening.profile
        yield profile.start, (profile.end, None if profile.text in strange else _PROFILE)
    if statement.kind == "SCENE":
        for head in statement.heads:
            yield head.start, (head.end, _DEFINITION)


def _unknown(analysis: Analysis, index: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the undefined names, and the unknown robots and senses of a statement."""
    statement, scope = analysis.statements[index], analysis.meanings[index].scope
    names = tuple(name for name, found in zip(statement.uses, scope, strict=True) if found is None)
    said = [each.span for each in analysis.infeasible.get(index, ()) if each.code in _UNKNOWN]
    return names, tuple(spelled(statement.text[span.start : span.end]) for span in said)


def _body_words(analysis: Analysis, index: int) -> tuple[str, ...]:
    """Return the words for body parts, and `to`, that a statement uses."""
    uses = analysis.statements[index].uses
    if analysis.predefined.keys().isdisjoint(uses):
        return ()
    return tuple(name for name in uses if takes(analysis, name, index) is not None)


def _comment_lines(text: str, start: int, end: int, first: int, last: int) -> Iterator[tuple[int, Uncolored]]:
    for comment in _COMMENT.finditer(text, start, end):
        if comment.start() <= last and comment.end() >= first:
            yield comment.start(), Uncolored(comment.group())


def _kind(name: str, *modifiers: str) -> tuple[int, int]:
    return TYPES.index(name), sum(1 << MODIFIERS.index(each) for each in modifiers)


_UNKNOWN = ("unknown-robot", "unknown-sense", "unknown-profile")
_COMMENT_KIND = _kind("comment")
_KEYWORD = _kind("keyword")
_UNIT = _kind("number")
_PROFILE = _kind("enumMember")
_BODY_WORD = _kind("keyword")
_POSE = _kind("enumMember")
_DEFINITION = _kind("variable", "definition")
_USE = _kind("variable")
_ROBOT = _kind("class")
_DECLARATION = _kind("parameter", "definition")
_PARAMETER = _kind("parameter")
_SENSE = _kind("property")
_BEFORE_SENSES = frozenset(of_kind(Kind.GUARD, Kind.IF, Kind.NOT))
_KINDS_OF_WORDS = {
    Kind.BEAT: _kind("modifier"),
    **dict.fromkeys((*TRANSFORMERS, Kind.IF, Kind.ELSE, Kind.NOT), _kind("keyword")),
    Kind.PRIMITIVE: _kind("function", "defaultLibrary"),
    Kind.PLANE: _kind("enumMember"),
}
_KINDS = {word.text: _KINDS_OF_WORDS[word.kind] for word in WORDS.values()}
_KINDS_BY_FORM = (_kind("operator"), _COMMENT_KIND, _USE, _kind("number"))  # in the order of the groups of _WORD
