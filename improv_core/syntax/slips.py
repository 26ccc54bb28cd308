"""The likeliest slips of newcomers, each with a message that says what to write, and a fix that writes it."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import suppress
from difflib import SequenceMatcher, get_close_matches
from fractions import Fraction
from itertools import takewhile
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.score.movement import STILL
from improv_core.score.primitives import PRIMITIVES
from improv_core.syntax.characters import SEPARATORS, is_name
from improv_core.syntax.lexer import Token
from improv_core.syntax.tried_words import TURNING
from improv_core.syntax.vocabulary import TRANSFORMERS, UNITS, of_kind
from improv_core.syntax.word import Kind
from improv_core.text import Span

_MOVEMENTS = of_kind(Kind.PRIMITIVE, *TRANSFORMERS)
_LONGEST_TAKEN_APART = 60
_BESIDE_WORDS = re.compile(r"^[^A-Za-z0-9]+|[^A-Za-z0-9]+$")
_LONGEST_ENDING = 2
"""The most extra characters at the end of a word: `forwards` has one."""
_SIMILAR, _VERY_SIMILAR = 0.7, 0.81
"""The similarity, from 0 to 1, at which a word is taken for another one with the same first letter, or with another."""
_SEPARATORS = frozenset({*SEPARATORS, "&", "+"})
_TEMPO = frozenset({"beat", "beats", "tempo", "bpm"})
_TEMPO_LINE = re.compile(r"(?:beats?|tempo|bpm) ?([\d.]+(?: [*/] [\d.]+)*)|([\d.]+) (?:beats?|bpm)", re.IGNORECASE)
_SCENE_LINE = re.compile(r"([^\W\d]\w*) :|(?i:scene) ([^\W\d]\w*)(?: :)?|((?i:scene) \d+)(?: :)?")
_PLACES = frozenset(
    {"in", "on", "behind", "beside", "next", "around", "between", "start", "starts", "stands", "begins"}
)
_WORDS = ("PRIMITIVE", "NAME")
_OPENERS = {"RPAR": "LPAR", "RSQB": "LSQB"}
FEWEST_DEGREES = 10
"""Fewer are steps or turns: nobody means ten quarter turns."""
OPPOSITES = {
    word: other
    for word, velocity in PRIMITIVES.items()
    for other, opposite in PRIMITIVES.items()
    if velocity.plus(opposite) == STILL
}


def nearest_word(name: str) -> str | None:
    """Return the word for movements that is most similar to a name, if one is."""
    return closest(name, _MOVEMENTS)


def closest(name: str, known: Collection[str]) -> str | None:
    """Return the known name that is most similar to another one, if one is.

    It never lacks a number, a word, or a sign of that name, so replacing the name loses nothing that was written.
    """
    plain = unicodedata.normalize("NFKC", name)
    if plain in known:
        return plain
    near = _similar(name, known) or _similar(plain.lower(), known)
    if near is None or _numerals(near) != _numerals(plain) or not is_name(near.replace("-", "_")):
        return None
    is_word = all(char.isalnum() or char in "_-" or unicodedata.category(char)[0] == "M" for char in plain)
    return near if is_word and not has_more(plain, near, known.__contains__) else None


def _similar(name: str, known: Collection[str]) -> str | None:
    """Return the most similar known name: one with another first letter must be more similar, and a beginning, such as
    `accum`, may be less."""
    near = next(iter(get_close_matches(name, known, n=1)), None)
    if not near or (len(name) > _LONGEST_ENDING and near.startswith(name)):
        return near
    least = _SIMILAR if name[0] == near[0] else _VERY_SIMILAR
    return near if SequenceMatcher(None, near, name).ratio() >= least else None


def has_more(name: str, near: str, is_known: Callable[[str], bool]) -> bool:
    """Return whether a name is a word like it and another word, or several known ones in a row."""
    if len(name) > _LONGEST_TAKEN_APART:
        return True
    ends = {0}
    for end in range(1, len(name) + 1):
        if any(is_known(_BESIDE_WORDS.sub("", name[start:end])) for start in ends):
            ends.add(end)
    if len(name) in ends and not is_known(name):
        return True
    rest = name.removeprefix(near) if name.startswith(near) else name.removesuffix(near)
    return near != name and rest != name and (is_known(rest.strip("_")) or len(rest) > _LONGEST_ENDING)


def _numerals(name: str) -> str:
    return "".join(char for char in name if char.isnumeric())


def without_sign(
    tokens: Sequence[Token],
    nearest: Callable[[str], str | None] = nearest_word,
    robot: str = "turtle1",
    is_used: Callable[[str], bool] = lambda name: False,
) -> Diagnostic:
    """Return the error about a statement that has neither `=` nor `$` and sets no tempo.

    `nearest` returns the word or name that its first word may stand for. Examples use the name `robot`. Other lines
    play a name that `is_used`.
    """
    if not tokens:
        return Diagnostic("syntax", Span(0, 0), _FORMS)
    first, second = tokens[0], tokens[1] if tokens[1:] else None
    whole = Span(first.start, tokens[-1].end)
    if other := _other_form(tokens, is_used):
        return other
    plays = Fix(f"Play it: {robot} $ …", (Edit(Span(first.start, first.start), f"{robot} $ "),), guess=True)
    if first.type in ("STRAY", "NUMBER"):
        return Diagnostic("syntax", whole, _FORMS)
    if first.type != "NAME":
        message = f"write a robot or a name before the movement: `{robot} $ …` or `name = …`"
        return Diagnostic("syntax", whole, message, (plays,))
    insert = Fix("Insert $", (Edit(Span(first.end, first.end), " $"),), guess=True)
    plays_second = second is not None and second.type == "NAME" and nearest(second.text)
    forgot = plays_second or (second is not None and second.type not in ("NAME", "STRAY", "NUMBER"))
    similar = nearest(first.text)
    if similar and SequenceMatcher(None, similar, first.text.lower()).ratio() >= _SIMILAR:
        form = f"{robot} $ {similar}{' …' if second else ''}"
        meant = Fix(f"Play it: {form}", (Edit(first.span, f"{robot} $ {similar}"),), guess=True)
        fixes = (meant, insert) if forgot and similar != first.text else (meant,)
        return Diagnostic("syntax", whole, f"write a robot first: `{form}`", fixes)
    if not forgot:
        return Diagnostic("syntax", whole, _FORMS, (plays,))
    message = f"write `$` after the robot's name: `{first.text} $ …`"
    return Diagnostic("syntax", first.span, message, (insert,))


def _other_form(tokens: Sequence[Token], is_used: Callable[[str], bool]) -> Diagnostic | None:
    """Return the error about a line that means one of ours in another form; None if it does not."""
    first, whole = tokens[0], Span(tokens[0].start, tokens[-1].end)
    words = [token.text.lower() for token in tokens]
    if tempo := tempo_meant(tokens):
        fixes = replace(f"Change to {tempo}", whole, tempo, safe=True)
        return Diagnostic("syntax", whole, f"write `{tempo}` to set the tempo", fixes)
    if words[1:] and tokens[1].type == "NUMBER" and (near := closest(words[0], ("room", "bar"))):
        form = f"{near} {words[1]}"
        return Diagnostic("syntax", first.span, f"write `{form}`", replace(f"Change to {near}", first.span, near))
    if scene := _SCENE_LINE.fullmatch(" ".join(token.text for token in tokens)):
        named = f"--- {next(filter(None, scene.groups())).replace(' ', '')}"
        fixes = replace(f"Change to {named}", whole, named)
        return Diagnostic("syntax", whole, f"write `{named}` to begin a scene", fixes)
    sign = next((token for token in tokens if token.type != "NAME"), first)
    arrow = next((token for token in tokens if token.start == sign.end and token.text == ">"), sign)
    if sign is not first and (sign.text in (":", "→", ".") or (sign.text == "-" and arrow.text == ">")):
        ours, span = "=" if is_used(first.text) else "$", Span(sign.start, arrow.end)
        fixes = replace(f"Change to {ours}", span, f" {ours}", safe=True)
        return Diagnostic("syntax", span, f"write `{ours}` instead of `{sign.text}{'>' * (arrow is not sign)}`", fixes)
    if words[0] == "speed" and words[1:]:
        hint = "write `beat 120` to set the tempo, or `fast 2` before a movement to double its speed"
        return Diagnostic("syntax", whole, hint)
    if words[0] in ("song", "music", "sound") and words[1:]:
        file = "".join(token.text for token in tokens[1:]).strip("=\"'")
        return Diagnostic("syntax", whole, f'set the song in improv.toml: under `[music]`, write `file = "{file}"`')
    if not _PLACES.isdisjoint(words[1:]) and all(token.type != "PRIMITIVE" for token in tokens):
        example = f"`{first.text} at circle 1.5`, or `{first.text} at -1 0 facing 90`"
        return Diagnostic("syntax", whole, f"write `at` and a formation or a place: {example}")
    return None


def tempo_meant(tokens: Sequence[Token]) -> str:
    """Return `beat 60` for a line that sets the tempo in other words, such as `tempo = 60` or `60 bpm`; otherwise
    an empty text."""
    line = _TEMPO_LINE.fullmatch(" ".join(token.text for token in tokens if token.text not in (":", "=")))
    return f"beat {(line[1] or line[2]).replace(' ', '')}" if line else ""


def without_tempo(tokens: Sequence[Token]) -> tuple[list[Token], list[Diagnostic]]:
    """Return the tokens up to `=` or `$` without a tempo, and the error if they begin with one."""
    if not _sets_tempo(tokens):
        return list(tokens), []
    end = _end_of_number(tokens, 2)
    tempo = f"beat {''.join(token.text for token in tokens[1:end])}"
    fixes = replace("Start a new line after it", Span(tokens[0].start, tokens[end].start), f"{tempo}\n")
    span = Span(tokens[0].start, tokens[end - 1].end)
    return list(tokens[end:]), [Diagnostic("syntax", span, f"write `{tempo}` on a line of its own", fixes)]


def without_separators(heads: Sequence[Token]) -> tuple[list[Token], list[Diagnostic]]:
    """Return the tokens before `$` without commas and the like, and the error if there are any."""
    separators = [token for token in heads if token.text in _SEPARATORS]
    if not separators:
        return list(heads), []
    touched = {token.start for token in heads}
    fix = Fix(
        f"Remove {separators[0].text}" if len(separators) == 1 else "Separate them with spaces",
        tuple(Edit(each.span, " " if each.end in touched else "") for each in separators),
        safe=True,
    )
    message = f"separate robots with spaces, without `{separators[0].text}`"
    kept = [token for token in heads if token.text not in _SEPARATORS]
    return kept, [Diagnostic("syntax", separators[0].span, message, (fix,))]


def is_between(heads: Sequence[Token], token: Token) -> bool:
    """Return whether `and` stands between the names of robots: then it is not meant as a robot."""
    return token.text == "and" and heads[0].start < token.start < heads[-1].start


def misplaced_number(tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """Return the error about a number without its word, as in `(forward) 2` or `2 forward`; None if this is none."""
    end, first = _end_of_number(tokens, at), at
    if at and tokens[at - 1].type in ("PRIMITIVE", *_OPENERS) and end > at and tokens[at].type == "OPERATOR":
        first += 1  # `forward*4`, `left/2`
    if end == first or tokens[first].type != "NUMBER":
        return None
    number = "1/" * (tokens[at].text == "/") + "".join(token.text for token in tokens[first:end]).removesuffix("*")
    if measured := _measure_first(tokens, at, end):
        return measured
    counts = [token.text for token in tokens[end : end + 1]] == ["times"]
    end += counts
    span = Span(tokens[at].start, tokens[end - 1].end)
    before = tokens[at - 1] if at else None
    if before and before.type in ("NUMBER", "PARAM"):
        message = "write one number here, not two"
        if number[0] in "+-":
            message = "numbers can be multiplied and divided, but not added or subtracted: write the result"
        return Diagnostic("syntax", span, message)
    after = tokens[end] if end < len(tokens) and tokens[end].start == span.end else None
    if after and after.type == "STRAY":
        return None
    start = _start_of_term(tokens, at - 1)
    if start is not None:
        last = tokens[at - 1]
        gone = Span(last.end if span.start - last.end <= 1 else span.start, span.end)
        is_counted = start > 0 and tokens[start - 1].type == "REPEAT"
        return Diagnostic(
            "syntax", span, *number_first(number, tokens[start], at - start == 1, gone, is_counted, counts)
        )
    if (
        before
        and before.text == "("
        and end < len(tokens)
        and [each.type for each in tokens[at - 2 : at - 1]] == ["REPEAT"]
    ):
        gone = Span(span.start, tokens[end].start)
        return Diagnostic("syntax", span, *number_first(number, before, False, gone, True, counts))
    if end < len(tokens) and tokens[end].type in (*_WORDS, *_OPENERS.values()):
        return Diagnostic(
            "syntax", span, *number_first(number, tokens[end], tokens[end].type in _WORDS, span, False, counts)
        )
    return None


def _measure_first(tokens: Sequence[Token], at: int, end: int) -> Diagnostic | None:
    """Return the error about a measure before its word, as in `1.5m forward`; None if this is none."""
    unit, word = [*tokens[end : end + 2], None, None][:2]
    if not unit or not word or unit.text not in UNITS or unit.start != tokens[end - 1].end or word.type != "PRIMITIVE":
        return None
    measure = "".join(token.text for token in tokens[at : end + 1])
    form, span = f"{word.text} {measure}", Span(tokens[at].start, word.end)
    return Diagnostic("syntax", span, f"write `{form}`", replace(f"Change to {form}", span, form))


def bracketed_number(tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """Return the error about a number in brackets, as in `poly (3)`; None if the error is another one."""
    start = at if at < len(tokens) and tokens[at].text == "(" else at - 1
    if start < 0 or tokens[start].text != "(":
        return None
    end = _end_of_number(tokens, start + 1)
    if end == start + 1 or end == len(tokens) or tokens[end].text != ")":
        return None
    number = "".join(token.text for token in tokens[start + 1 : end])
    edits = (Edit(tokens[start].span, ""), Edit(tokens[end].span, ""))
    message = f"write `{number}` without brackets: only movements can stand in them"
    span = Span(tokens[start].start, tokens[end].end)
    return Diagnostic("syntax", span, message, (Fix("Remove the brackets", edits, safe=True),))


def number_first(
    number: str, term: Token, is_word: bool, gone: Span, is_counted: bool = False, counts: bool = False
) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about a number without its word, and its fixes. They remove it at `gone` and write it before
    the term that starts with this token. If the term `is_counted`, it follows a `repeat` that lacks its number. If the
    number `counts`, as in `4 times`, it scales nothing."""
    ways = [
        each
        for each in _readings(number, term.text if is_word else None, is_counted)
        if not counts or "scale" not in each.before
    ]
    if not ways:
        what = "`repeat` takes a whole number above 0" if is_counted else "it does not change this movement"
        return f"remove `{number}`: {what}", ()
    kept = term.text if is_word else "( … )" if term.text == "(" else "[ … ]"
    shown = [" ".join([*(["repeat"] if is_counted else []), *way.before, way.word or kept]) for way in ways]
    message = f"write {' or '.join(f'`{title}`' for title in shown)}"
    if gone.end > term.start and any(way.before and way.before[-1] != "retrograde" for way in ways):
        message += ": the number comes first"
    fixes = [
        Fix(f"Change to {title}", _edits(way, term, gone), guess=way.drops)
        for title, way in zip(shown, ways, strict=True)
    ]
    return message, tuple(fixes)


def is_like_a_robot(name: str) -> bool:
    """Return whether a name looks like that of a robot: turtlesim's are `turtle1`, `turtle2`, …"""
    return bool(_ROBOT.fullmatch(name))


_ROBOT = re.compile(r"(turtle|robot)_?[0-9]*")
_FORMS = "write `robot $ movement`, `name = movement`, or `beat 60`"


class _Reading(NamedTuple):
    """A likely meaning of a term and a number: words `before` the term, and a `word` that replaces it, if needed.
    For 1 or 0, the reading `drops` the number."""

    before: tuple[str, ...]
    word: str | None = None
    drops: bool = False


def _readings(number: str, word: str | None, is_counted: bool) -> Iterator[_Reading]:
    """Yield likely meanings of a number next to a term, which is a `word` or in brackets. Yield only correct ones."""
    value = value_of(number)
    if value is None:
        return
    if is_counted:  # the number after `repeat`
        if value >= 1 and value.denominator == 1:
            yield _Reading((number,))
        return
    if word in TURNING and abs(value) >= FEWEST_DEGREES:
        side = word if value > 0 else OPPOSITES[word]
        yield _Reading((), f"{side.removeprefix('half')} {number.lstrip('+-')}deg")
        return
    meant, back = word, tuple[str, ...]()
    if value < 0:
        meant = OPPOSITES.get(word or "")
        back = () if meant else ("retrograde",)
        number = number.removeprefix("-") if value_of(number.removeprefix("-")) == -value else str(-value)
    if not value:
        if word:
            yield _Reading((), "rest", drops=True)
        return
    changed = meant if meant != word else None
    if abs(value) == 1:
        yield _Reading(back, changed, drops=True)
        return
    if number.isdecimal():
        yield _Reading(("repeat", number, *back), changed)
    if word != "rest":
        yield _Reading(("scale", number, *back), changed)


def _edits(way: _Reading, term: Token, gone: Span) -> tuple[Edit, ...]:
    before = " ".join(way.before)
    word = [Edit(term.span, way.word)] if way.word and way.word != term.text else []
    if gone.end > term.start:
        first = [Edit(Span(term.start, term.start), f"{before} ")] if before else []
        if word and before:
            first, word = [], [Edit(term.span, f"{before} {way.word}")]
        return (*first, *word, Edit(gone, ""))
    # A single character between two tokens is a space. A longer gap may contain a comment.
    end = term.start if not before and term.start - gone.end == 1 else gone.end
    return (Edit(Span(gone.start, end), before), *word)


def value_of(number: str) -> Fraction | None:
    """Return the value of numbers with `*` and `/` between them; None if there is none."""
    first, *rest = re.split(r"([*/])", number)
    with suppress(ValueError, ZeroDivisionError):
        value = Fraction(first)
        for sign, factor in zip(rest[::2], rest[1::2], strict=True):
            value = value * Fraction(factor) if sign == "*" else value / Fraction(factor)
        return value
    return None


def _sets_tempo(tokens: Sequence[Token]) -> bool:
    return [token.type for token in tokens[1:2]] == ["NUMBER"] and tokens[0].text.lower() in _TEMPO


def _end_of_number(tokens: Sequence[Token], at: int) -> int:
    """Return the index after the numbers, and the signs between them, that begin at an index."""
    return at + sum(1 for _ in takewhile(lambda token: token.type in ("NUMBER", "OPERATOR"), tokens[at:]))


def _start_of_term(tokens: Sequence[Token], last: int) -> int | None:
    """Return the index at which the word or bracket that ends at the index `last` starts."""
    if last < 0:
        return None
    token = tokens[last]
    if token.type in _WORDS:
        return last
    depth = 0
    for place in range(last, -1, -1) if token.type in _OPENERS else ():
        depth += (tokens[place].type in _OPENERS) - (tokens[place].type in _OPENERS.values())
        if not depth:
            return place
    return None
