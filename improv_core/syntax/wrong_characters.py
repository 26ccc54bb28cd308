"""Errors about characters of other keyboards that can't be read as ours.

Each error has the one likely fix, which never deletes a number, joins two, or splits one.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import takewhile

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.syntax.brackets import BRACKETS
from improv_core.syntax.characters import (
    CLOSERS,
    DASHES,
    DECIMAL_COMMAS,
    DEGREES,
    LINE_ENDS,
    MEANT,
    OPENERS,
    UNSEEN,
    in_words,
)
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import UNITS, WORDS
from improv_core.text import Span

LONGEST_EXPONENT = 2
MAX_PARTS = 12
"""The most tokens before and after one of a number in a foreign notation."""
_PLACES = frozenset({"at", "around", "facing"})
_PARTS = frozenset({"NUMBER", "NAME", "STRAY"})
_SIGNS = frozenset({"BAR", "EQUAL", "DOLLAR", "OPERATOR", "STRAY", *BRACKETS})
_QUOTES_AND_PICTURES = ("Pi", "Pf", "So")
_NOTHING = "\"'`.!?…"
"""Characters that mean nothing in a movement. No fix removes other characters, such as `&` and `^`, since people may
mean something by them."""

IsRight = Callable[[str], bool]
"""Returns whether a text is a statement without errors."""


def wrong_character(text: str, tokens: Sequence[Token], is_right: IsRight) -> Diagnostic | None:
    """Return the error about the first character of a statement that has no meaning here, but a likely one."""
    if scene := _dashes(text, tokens):
        return scene
    is_movement = any(token.type in ("EQUAL", "DOLLAR") for token in tokens)
    place = next((at for at, token in enumerate(tokens) if token.text in _PLACES), len(tokens))
    for at, token in enumerate(tokens):
        if token.type == "STRAY":
            found = _comma(text, tokens, at, is_right) or number_meant(tokens, at) or _unseen(text, tokens, at)
            found = (
                found
                or (_minus(text, tokens, at) if place < at and not is_movement else None)
                or _sign(text, tokens, at)
            )
            if found:
                return found
        elif not is_movement and token.type == "NAME" and (found := number_meant(tokens, at)):
            return found
    return None


def number_meant(tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """Return the error about a number in a foreign notation, such as `1½` or `50%`, of which this token is a part."""
    if not _MAY_BE_IN_NUMBERS.fullmatch(tokens[at].text):
        return None
    first = last = at
    while first and _touches(tokens, first - 1) and tokens[first - 1].type in _PARTS:
        first -= 1
        if at - first > MAX_PARTS:
            return None
    while _touches(tokens, last) and tokens[last + 1].type in _PARTS:
        last += 1
        if last - at > MAX_PARTS:
            return None
    written = "".join([token.text for token in tokens[first : last + 1]])
    unit = _UNIT_AT_END.findall(written)[0]
    written = written.removesuffix(unit)
    matches = ((pattern.fullmatch(written), meant) for pattern, meant in _FORMS)
    found = next((meant(match) for match, meant in matches if match), None)
    if not found:
        return None
    value, why = found
    if first and tokens[first - 1].text == "/" and isinstance(value, Fraction):
        value = _decimal(value)
    span = Span(tokens[first].start, tokens[last].end)
    if value is None:
        return Diagnostic("syntax", span, why.removeprefix(": "))
    meant = f"{value}{unit}"
    return Diagnostic("syntax", span, f"write `{meant}`{why}", replace(f"Change to {meant}", span, meant))


def can_remove(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a fix may remove a stray: it means nothing, and touches neither a number nor a name."""
    stray = tokens[at].text
    beside = [tokens[at - 1]] if at and _touches(tokens, at - 1) else []
    beside += [tokens[at + 1]] if _touches(tokens, at) else []
    is_picture = unicodedata.category(stray) in _QUOTES_AND_PICTURES
    means_nothing = stray in _NOTHING or is_picture or not stray.isprintable()
    return means_nothing and all(token.type in _SIGNS and token.type != "OPERATOR" for token in beside)


def shown(token: Token) -> str:
    """Describe a stray in a message: in words with its code, unless it is a usual character."""
    char = token.text
    if char.isascii() and char.isprintable():
        return f"`{char}`"
    words = in_words(char)
    return f"`{char}`, {words}" if char.isprintable() else f"this {words.partition(' ')[2]}"


def unseen_joins(tokens: Sequence[Token], span: Span) -> tuple[str, str, str] | None:
    """Return the two parts of a word around an invisible character, and the whole; None if one of them is a number."""
    before = next((token for token in tokens if token.end == span.start), None)
    after = next((token for token in tokens if token.start == span.end), None)
    if not before or not after or not {before.type, after.type}.isdisjoint({"NUMBER", "STRAY"}):
        return None
    return before.text, after.text, before.text + after.text


def _dashes(text: str, tokens: Sequence[Token]) -> Diagnostic | None:
    """Return the error about dashes that are meant as the three that begin a scene."""
    dashes = list(takewhile(lambda token: token.type in ("STRAY", "SCENE") and token.text[0] in DASHES, tokens))
    rest = tokens[len(dashes) :]
    if not dashes or len(rest) > 1 or [each.type for each in dashes] == ["SCENE"]:
        return None
    span = Span(dashes[0].start, dashes[-1].end)
    written = text[slice(*span)]
    if rest and (rest[0].type != "NAME" or (len(dashes) == 1 and written == "-")):
        return None
    other = next((char for char in written if not char.isascii() and not char.isspace()), None)
    message = "write `---` to begin a new scene" + (f": this is {in_words(other)}" if other else "")
    touches = bool(rest) and rest[0].start == span.end
    return Diagnostic("syntax", span, message, replace("Change to ---", span, "--- " if touches else "---", safe=True))


def _minus(text: str, tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """Return the error about a dash that is meant as the sign of a number in a place."""
    token = tokens[at]
    is_sign = token.text in DASHES and _touches(tokens, at) and tokens[at + 1].type == "NUMBER"
    if not is_sign or (at and _touches(tokens, at - 1)):
        return None
    message = f"write `-` before a number: this is {in_words(text[token.start])}"
    return Diagnostic("syntax", token.span, message, replace("Change to -", token.span, "-"))


def _comma(text: str, tokens: Sequence[Token], at: int, is_right: IsRight) -> Diagnostic | None:
    """Return the error about a comma within a number, or between two."""
    span = tokens[at].span
    if tokens[at].text not in DECIMAL_COMMAS or not _is_between_numbers(tokens, at):
        return None
    first, last = tokens[at - 1], tokens[at + 1]
    message = f"this is {in_words(text[span.start])}: numbers have a point"
    is_long = _is_comma(tokens, at - 2) or _is_comma(tokens, at + 2) or "." in first.text + last.text
    if is_long or (len(last.text) == 3 and first.text.lstrip("+-0")):
        return Diagnostic("syntax", span, f"{message}, and nothing between thousands")
    commas = [each.span for place, each in enumerate(tokens) if _is_comma(tokens, place)]
    if tokens[at].text == "," and not is_right(_written(text, commas, ".")) and is_right(_written(text, commas, " ")):
        apart = f"{first.text} {last.text}"
        fixes = replace(f"Change to {apart}", span, " ")
        return Diagnostic("syntax", span, "remove `,`: separate numbers with spaces", fixes)
    return Diagnostic("syntax", span, message, replace(f"Change to {first.text}.{last.text}", span, "."))


def _is_comma(tokens: Sequence[Token], at: int) -> bool:
    return 0 < at < len(tokens) and tokens[at].text in DECIMAL_COMMAS and _is_between_numbers(tokens, at)


def _is_between_numbers(tokens: Sequence[Token], at: int) -> bool:
    kinds = [token.type for token in (tokens[at - 1], *tokens[at + 1 : at + 2])] if at else []
    is_number = kinds == ["NUMBER", "NUMBER"] and tokens[at + 1].text[0] not in "+-"
    return is_number and _touches(tokens, at - 1) and _touches(tokens, at)


def _written(text: str, places: Sequence[Span], by: str) -> str:
    """Return the text with each of these characters replaced."""
    chars = list(text)
    for place in places:
        chars[place.start] = by
    return "".join(chars)


def _unseen(text: str, tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """Return the error about an invisible character within a word or a number."""
    if tokens[at].text not in UNSEEN:
        return None
    strays = list(takewhile(lambda token: token.text in UNSEEN, tokens[at:]))
    span = Span(strays[0].start, strays[-1].end)
    what = in_words(text[span.start])
    parts = unseen_joins(tokens, span)
    if not parts:
        return Diagnostic("syntax", span, f"there is {what}, in this number: write it again")
    fixes = replace("Remove it", span, "") if parts[2] in WORDS else ()
    return Diagnostic("syntax", span, f"there is {what}, in this word: remove it", fixes)


def _sign(text: str, tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """Return the error about a sign that is meant as one of ours."""
    token = tokens[at]
    if token.text in LINE_ENDS:
        message = f"start a new line here: this is {in_words(token.text)}"
        # Replace all at once: the text after the next one may be a comment.
        edits = [Edit(Span(at, at + 1), "\n") for at, char in enumerate(text) if char in LINE_ENDS]
        return Diagnostic("syntax", token.span, message, (Fix("Start a new line", tuple(edits)),))
    if not token.text.isprintable():
        gone = replace("Remove it", token.span, "") if can_remove(tokens, at) else ()
        return Diagnostic("syntax", token.span, f"remove {shown(token)}: it is not part of the language", gone)
    if token.text == "°" and at and tokens[at - 1].type == "NUMBER" and not _touches(tokens, at - 1):
        number = tokens[at - 1]
        message = f"write the unit directly behind the number: `{number.text}°`"
        fixes = replace(f"Change to {number.text}°", Span(number.end, token.start), "")
        return Diagnostic("missing-unit", Span(number.start, token.end), message, fixes)
    what = in_words(text[token.start])
    if token.text in OPENERS + CLOSERS:
        fixes = tuple(_brackets(tokens, kind) for kind in ("()", "[]"))
        either = "`(` or `[`" if token.text in OPENERS else "`)` or `]`"
        return Diagnostic("syntax", token.span, f"write {either} here: this is {what}", fixes)
    meant = MEANT.get(token.text)
    if not meant:
        return None
    message = f"write `{meant}` here: this is {what}"
    return Diagnostic("syntax", token.span, message, replace(f"Change to {meant}", token.span, meant))


def _brackets(tokens: Sequence[Token], kind: str) -> Fix:
    """Return the fix that writes these brackets in place of all that may be of either kind."""
    places = [token for token in tokens if token.type == "STRAY" and token.text in OPENERS + CLOSERS]
    edits = [Edit(token.span, kind[token.text in CLOSERS]) for token in places]
    return Fix(f"Change to {' '.join(kind)}", tuple(edits), guess=True)


def _touches(tokens: Sequence[Token], at: int) -> bool:
    """Return whether nothing is between a token and the next."""
    return at + 1 < len(tokens) and tokens[at].end == tokens[at + 1].start


_Meant = tuple[Fraction | str | None, str]
"""The value or the text of a number in a foreign notation, and the explanation. Without a value, no number can replace
it."""


def _mixed(match: re.Match[str]) -> _Meant:
    sign, whole, part = match.groups()
    value = Fraction(whole or 0) + _fraction(part)
    return (value if not sign else f"{sign}{value}"), f": this is {in_words(part)}"


def _foreign(match: re.Match[str]) -> _Meant:
    if any(char.isascii() and char.isdecimal() for char in match[0]):
        foreign = next(char for char in match[0] if not char.isascii())
        return None, f": this number has digits of two scripts: one is {in_words(foreign)}"
    digits = "".join(str(unicodedata.decimal(char)) if char.isdecimal() else "." for char in match[0])
    return digits, f": this is {in_words(match[0][0])}"


def _fraction(char: str) -> Fraction:
    """Return the value of a vulgar fraction: ½ is `<fraction> 0031 2044 0032`."""
    above, _, below = "".join(chr(int(code, 16)) for code in unicodedata.decomposition(char).split()[1:]).partition("⁄")
    return Fraction(int(above), int(below))


def _decimal(value: Fraction) -> str | None:
    """Return a value without a `/`, to write it after one; None if it has no finite decimal form."""
    digits = f"{Decimal(value.numerator) / value.denominator:.9f}".rstrip("0").rstrip(".")
    return digits if Fraction(digits) == value else None


_VULGAR = "".join(
    char
    for char in map(chr, [*range(0xBC, 0xBF), *range(0x2150, 0x218A)])
    if len(unicodedata.decomposition(char).partition("2044")[2]) > 0
)
_UNIT = rf"(?:{'|'.join(UNITS)})?"
_UNIT_AT_END = re.compile(rf"{_UNIT}\Z")
_MAY_BE_IN_NUMBERS = re.compile(rf"[{_VULGAR}]{_UNIT}|[{DECIMAL_COMMAS}{DEGREES}%]|[-+.\d]+|[eE](?:[0-9]+{_UNIT})?")
_DIGITS = r"[0-9]*\.?[0-9]+"
_FORMS: Sequence[tuple[re.Pattern[str], Callable[[re.Match[str]], _Meant]]] = (
    (re.compile(rf"([+-]?)([0-9]*)([{_VULGAR}])"), _mixed),
    (re.compile(rf"({_DIGITS})%"), lambda found: (Fraction(found[1]) / 100, f" instead of `{found[0]}`")),
    (re.compile(rf"(?=.*[^\x00-\x7f])\d+(?:[.{DECIMAL_COMMAS}]\d+)?"), _foreign),
    (
        re.compile(rf"{_DIGITS}[eE][+-]?[0-9]{{1,{LONGEST_EXPONENT}}}"),
        lambda found: (Fraction(found[0].lower()), f" instead of `{found[0]}`"),
    ),
    (
        re.compile(rf"({_DIGITS})([{DEGREES}])"),
        lambda found: (f"{found[1]}°", f": this is {in_words(found[2])}, and no degree sign"),
    ),
)
