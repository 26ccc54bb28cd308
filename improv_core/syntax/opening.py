"""The lines of the opening: the places and profiles of robots, the floor, the bar, and the names of scenes.

Their words are names everywhere else. A line with `=` or `$` is never one of them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from improv_core.diagnostics import Diagnostic, Fix, replace
from improv_core.syntax.brackets import BRACKETS
from improv_core.syntax.characters import NAME, SEPARATORS, is_name, shape, usual
from improv_core.syntax.descent import number_of
from improv_core.syntax.heads import joined_touching, robots_head
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import AtPoint, BarLength, FloorSize, InFormation, Number, OfKind, OpeningNode, Statement
from improv_core.syntax.slips import closest, value_of
from improv_core.syntax.units import misplaced_unit, unit_meant
from improv_core.syntax.vocabulary import UNITS
from improv_core.syntax.word import Kind
from improv_core.text import Span

SHAPES = ("circle", "line", "grid")
"""The formations that robots can stand in."""
FACINGS = ("in", "out")
"""The directions that robots on a circle can face."""
_PROFILE = re.compile(rf"{NAME}(?:-+\w+)*")
_WORDS = frozenset({kind.value for kind in Kind})
_SIZES = {"circle": "the radius of the circle", "line": "the distance between neighbors"}
_EXAMPLES = {"circle": "1.5", "line": "1", "grid": "1"}


def opening_line(text: str, tokens: Sequence[Token]) -> Statement | None:
    """Read the tokens of a statement as a line of the opening, perhaps with an error; None if they are none.

    It has no node if it begins a scene or has an error.
    """
    types = [token.type for token in tokens]
    if not tokens or "EQUAL" in types or "DOLLAR" in types or types[:2] == ["BEAT", "NUMBER"]:
        return None
    if types[0] == "SCENE":
        return _scene(text, tokens)
    place = _kind_at(text, tokens)
    if place is None:
        place = _place_at(tokens)
    if place is not None:
        sign = tokens[place]._replace(type=tokens[place].text.upper())
        head = robots_head(text, tokens[:place], sign)
        return _read(text, sign, head.names, tokens[place + 1 :], head.diagnostics)
    if tokens[0].text in _FLOOR and types[1:2] == ["NUMBER"]:
        return _read(text, tokens[0]._replace(type=_FLOOR[tokens[0].text]), (), tokens[1:], ())
    return None


_FLOOR = {"room": "ROOM", "bar": "BAR_LENGTH"}


def _kind_at(text: str, tokens: Sequence[Token]) -> int | None:
    """Return the index of the `is` of a line that gives robots a profile; None if it doesn't."""
    place = next((place for place in range(1, len(tokens)) if _is_profile(text, tokens, place)), None)
    if place is None and _WORDS.isdisjoint(token.type for token in tokens):
        lacking = (place for place, token in enumerate(tokens) if place and token.text == "is")
        place = next(lacking, None) if _place_at(tokens) is None else None
    return place


def _is_profile(text: str, tokens: Sequence[Token], place: int) -> bool:
    """Return whether a token is an `is` with only a profile after it and only names before it."""
    if tokens[place].text != "is" or len(tokens) == place + 1:
        return False
    names = joined_touching(text, tokens[:place])
    profile = text[tokens[place + 1].start : tokens[-1].end]
    return _PROFILE.fullmatch(shape(profile)) is not None and all(is_name(each.text) for each in names)


def _place_at(tokens: Sequence[Token]) -> int | None:
    """Return the index of the `at` of a line that places robots; None if it doesn't."""
    found = [place for place, token in enumerate(tokens) if token.text == "at"]
    for place in found:
        if place and _begins_place(tokens, place + 1):
            return place
    if found == [0] and _begins_place(tokens, 1):
        return 0  # the robot is missing
    # In a line without a movement, `at` is not meant as the name of a robot.
    return next((place for place in found if place and _WORDS.isdisjoint(token.type for token in tokens)), None)


def _begins_place(tokens: Sequence[Token], place: int) -> bool:
    return any(token.type == "NUMBER" or token.text in SHAPES for token in tokens[place : place + 1])


def _scene(text: str, tokens: Sequence[Token]) -> Statement:
    sign, *rest = tokens
    if not rest:
        return Statement(text, (), sign)
    first, *others = joined_touching(text, rest)
    wrong: tuple[Diagnostic, ...] = ()
    if not is_name(first.text):
        message = f"`{first.text}` can't name a scene: use letters, digits, and `_`, starting with a letter"
        wrong = (Diagnostic("syntax", first.span, message),)
    elif others:
        whole = Span(first.start, others[-1].end)
        joined = "_".join(re.findall(r"\w+", text[slice(*whole)]))
        fixes = replace(f"Change to {joined}", whole, joined)
        plays = any(token.type in ("DOLLAR", "EQUAL") for token in rest)
        message = f"write one name after `---`, {'or start a new line' if plays else f'such as `{joined}`'}"
        wrong = (Diagnostic("syntax", others[0].span, message, fixes),)
    return Statement(text, wrong, sign, (first._replace(type="HEAD"),))


def _read(
    text: str, sign: Token, heads: tuple[Token, ...], rest: Sequence[Token], wrong: tuple[Diagnostic, ...]
) -> Statement:
    reader = _Reader(text, sign, heads, rest)
    node = None
    try:
        node = reader.node()
    except _WrongError as error:
        wrong = wrong or (error.diagnostic,)
    return Statement(text, wrong, sign, heads, opening=None if wrong else node, words=tuple(reader.words))


class _WrongError(Exception):
    """An error in a line of the opening."""

    def __init__(self, span: Span, message: str, fixes: tuple[Fix, ...] = (), code: str = "syntax") -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic(code, span, message, fixes)


class _Reader:
    """Reads the tokens after a sign, from left to right."""

    def __init__(self, text: str, sign: Token, heads: Sequence[Token], tokens: Sequence[Token]) -> None:
        self._text, self._sign, self._heads = text, sign, heads
        self._tokens, self._place = tokens, 0
        self.words = [sign]

    @property
    def _next(self) -> Token | None:
        return self._tokens[self._place] if self._place < len(self._tokens) else None

    @property
    def _last(self) -> Token:
        return self._tokens[self._place - 1] if self._place else self._sign

    def node(self) -> OpeningNode:
        read = {"AT": self._at, "IS": self._is, "ROOM": self._room, "BAR_LENGTH": self._bar}
        node = read[self._sign.type]()
        if extra := self._next:
            self._check_spelling(("facing", "around"))
            if extra.type == "NUMBER" and self._last.type == "NUMBER" and extra.text[0] in "+-":
                message = "numbers can be multiplied and divided, but not added or subtracted: write the result"
                raise _WrongError(extra.span, message)
            whole = Span(extra.start, self._tokens[-1].end)
            has_number = any(token.type == "NUMBER" for token in self._tokens[self._place :])
            fixes = () if has_number else replace("Remove it", Span(self._last.end, whole.end), "", guess=True)
            raise _WrongError(whole, f"remove `{extra.text}` or start a new line before it", fixes)
        return node

    def _at(self) -> OpeningNode:
        if self._next and self._next.text in SHAPES:
            return self._formation(self._word())
        self._check_spelling(SHAPES)
        robot = self._heads[0].text or "ada"
        example = f"write x and y in meters after `at`: `{robot} at 1 0.5`"
        if not self._next or self._next.type not in ("NUMBER", "LPAR"):
            raise self._expected(f"{example}, or `circle`, `line`, or `grid`", "0 0")
        x, y = self._point(example)
        facing = None
        if self._next and self._next.text == "facing":
            self._word()
            expected = "write degrees after `facing`, counterclockwise from the x axis: `facing 90`"
            facing = self._number(expected, "0", field="degrees")
        if len(self._heads) > 1:
            raise self._too_many(x, y, facing)
        return AtPoint(x, y, facing)

    def _too_many(self, x: Number, y: Number, facing: Number | None) -> _WrongError:
        first, last = self._heads[0], self._heads[-1]
        if last.text in ("start", "starts", "begins", "stands"):
            fixes = replace(f"Remove {last.text}", Span(self._heads[-2].end, last.end), "")
            return _WrongError(last.span, f"write only `at`, without `{last.text}`", fixes)
        line = f"line 1 around {x.text} {y.text}"
        place = Span(self._sign.end, y.span.end)  # there may be no space before a sign
        fixes = () if facing else replace(f"Change to {line}", place, f" {line}")
        message = f"only one robot can stand at a point: write `{line}`, or a line for each robot"
        return _WrongError(Span(first.start, last.end), message, fixes)

    def _formation(self, shape: Token) -> InFormation:
        what = _SIZES.get(shape.text, _SIZES["line"])
        example = _EXAMPLES[shape.text]
        size = self._number(f"write {what}, in meters: `{shape.text} {example}`", example, signed=False)
        facing: Token | None = None
        around: tuple[Number, Number] | None = None
        while (option := self._next) and option.text in ("facing", "around"):
            if (facing if option.text == "facing" else around) is not None:
                raise _WrongError(option.span, f"write `{option.text}` once only")
            before = self._last
            self._word()
            if option.text == "around":
                around = self._point("write x and y of the middle, in meters: `around 2 0`")
                continue
            if shape.text != "circle":
                gone = Span(before.end, (self._next or option).end)
                message = f"`facing` works only with `circle`: remove it from this {shape.text}"
                is_number = self._next is not None and self._next.type == "NUMBER"
                raise _WrongError(option.span, message, () if is_number else replace("Remove it", gone, ""))
            if not self._next or self._next.text not in FACINGS:
                raise self._expected("write `in` or `out` after `facing`", "in")
            facing = self._word()
        return InFormation(shape, size, facing, around)

    def _is(self) -> OfKind:
        if not self._next:
            raise self._expected(f"write a profile after `is`: `{self._heads[0].text or 'ada'} is turtlesim`", "")
        whole = Span(self._next.start, self._tokens[-1].end)
        profile = usual(self._text[slice(*whole)])
        if not _PROFILE.fullmatch(shape(profile)):
            gone = Span(self._next.start, self._tokens[-1].start)
            fixes = replace("Remove a", gone, "", safe=True) if self._next.text in ("a", "an") else ()
            raise _WrongError(whole, "write only the name of a profile after `is`", fixes)
        self._place = len(self._tokens)
        return OfKind(Token("PROFILE", profile, *whole))

    def _room(self) -> FloorSize:
        example = "write the floor's length along x and along y, in meters: `room 6 4`"
        if times := next((token for token in self._tokens if self._text[token.start] == "×"), None):
            fixes = replace("Change to a space", times.span, " ")
            raise _WrongError(times.span, "separate the two lengths with a space: `room 6 4`", fixes)
        width = self._number(example, "6", signed=False)
        if (times := self._next) and (found := re.fullmatch(r"(?:[xX]|by)(\d*)", times.text)):
            fixes = replace(f"Change to {width.text} {found[1]}".rstrip(), times.span, f" {found[1]}".rstrip() or " ")
            raise _WrongError(times.span, "separate the two lengths with a space: `room 6 4`", fixes)
        self._no_comma()
        return FloorSize(width, self._number(example, width.text, signed=False))

    def _bar(self) -> BarLength:
        return BarLength(self._number("write the beats of a bar: `bar 3`", "3", signed=False, field=""))

    def _point(self, example: str) -> tuple[Number, Number]:
        x = self._number(example, "0 0")
        self._no_comma()
        return x, self._number(example, "0")

    def _number(self, expected: str, usual: str, *, signed: bool = True, field: str = "meters") -> Number:
        """Read the next number. If there is none, the error asks for `expected`, and a fix writes the `usual` one.

        One of its literals may have a unit of this `field` of measures.
        """
        found = self._next
        if found is None or found.type != "NUMBER":
            raise self._expected(expected, usual)
        factors = [found]
        self._place += 1
        self._unit(factors, field)
        while (operator := self._next) and operator.type == "OPERATOR":
            self._place += 1
            factor = self._next
            if factor is None or factor.type != "NUMBER":
                raise _WrongError((factor or operator).span, f"write a number after `{operator.text}`")
            if factor.text[0] in "+-":
                raise _WrongError(factor.span, "write a sign before the first number only")
            factors += [operator, factor]
            self._place += 1
            self._unit(factors, field)
        if not signed and found.text[0] in "+-":
            plain = found.text[1:]
            message = f"write `{plain}` without a sign: this number is above 0"
            raise _WrongError(found.span, message, replace(f"Change to {plain}", found.span, plain))
        return number_of(factors)

    def _unit(self, factors: list[Token], field: str) -> None:
        """Read the unit directly behind the last number, if there is one."""
        unit = self._next
        if not unit or not unit_meant(unit.text) or not field:
            return
        if unit.start > factors[-1].end or unit.text not in UNITS:
            number = number_of(factors)
            message, title, edit = misplaced_unit(number, value_of(number.text), unit)
            raise _WrongError(unit.span, message, (Fix(title, (edit,)),))
        if UNITS[unit.text].field != field:
            wanted = "an angle, such as `90deg`" if field == "degrees" else "a length, such as `50cm`"
            raise _WrongError(Span(factors[0].start, unit.end), f"this takes {wanted}", code="wrong-measure")
        if any(each.type == "UNIT" for each in factors):
            raise _WrongError(unit.span, f"a measure has one unit: remove `{unit.text}`", code="wrong-measure")
        factors.append(unit._replace(type="UNIT"))
        self.words.append(factors[-1])
        self._place += 1

    def _word(self) -> Token:
        token = self._next
        assert token
        self.words.append(token)
        self._place += 1
        return token

    def _no_comma(self) -> None:
        if (found := self._next) and found.text in SEPARATORS:
            is_apart = self._text[found.end : found.end + 1].isspace()
            fixes = replace(f"Remove {found.text}", found.span, "" if is_apart else " ", safe=is_apart)
            raise _WrongError(found.span, f"remove `{found.text}`: separate numbers with spaces", fixes)

    def _check_spelling(self, words: Sequence[str]) -> None:
        """Raise an error if the next word is nearly one of these."""
        if self._next and (near := closest(self._next.text, words)) and near != self._next.text:
            fixes = replace(f"Change to {near}", self._next.span, near)
            raise _WrongError(self._next.span, f"did you mean `{near}`?", fixes)

    def _expected(self, message: str, usual: str) -> _WrongError:
        """Return the error that asks for what should come next."""
        found = self._next
        if found is None:
            end = Span(self._last.end, self._last.end)
            fixes = replace(f"Add {usual}", end, f" {usual}", guess=True) if usual else ()
            return _WrongError(self._last.span, message, fixes)
        if found.type in BRACKETS and (number := _bracketed(self._text, self._tokens[self._place :])):
            inside, whole = number
            return _WrongError(whole, message, replace("Remove the brackets", whole, inside))
        return _WrongError(found.span, message)


def _bracketed(text: str, tokens: Sequence[Token]) -> tuple[str, Span] | None:
    """Return numbers in brackets as they should be written, and the span of the whole."""
    closer = next((place for place, token in enumerate(tokens) if token.type == "RPAR"), None)
    if closer is None:
        return None
    inside = text[tokens[0].end : tokens[closer].start].strip()
    return re.sub(r"[,;](?=\s)", "", inside), Span(tokens[0].start, tokens[closer].end)
