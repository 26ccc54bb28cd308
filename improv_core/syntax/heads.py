"""The part of a statement before its sign: a name and its parameters, or robots; and the kinds of names by place."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from improv_core.diagnostics import Diagnostic, Fix, replace
from improv_core.syntax.brackets import BRACKETS, close_brackets
from improv_core.syntax.characters import is_name
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Parameter
from improv_core.syntax.slips import tempo_meant, without_separators, without_sign, without_tempo
from improv_core.syntax.vocabulary import RADIUS, UNITS
from improv_core.text import Span
from improv_core.values import value

_BEFORE_SENSES = frozenset({"GUARD", "IF", "NOT"})
_IN_MEASURES = frozenset({"NUMBER", "PARAM", "OPERATOR", "UNIT"})


@value(frozen=True, slots=True)
class Head:
    """The names before the sign (as HEAD tokens), the parameters, the sign, and the errors in them.

    `declared` is the text from the first parameter to the last.
    """

    names: tuple[Token, ...]
    sign: Token | None
    parameters: tuple[Parameter, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    declared: Span | None = None

    def of_other_kind(self, name: str) -> tuple[Fix, ...]:
        """Return the fix that makes a number of a parameter that is a movement, or the reverse."""
        kinds = {each.name: each.is_number != (each.name == name) for each in self.parameters}
        numbers = [each for each, is_number in kinds.items() if is_number]
        movements = [f"({each})" for each, is_number in kinds.items() if not is_number]
        assert self.declared
        return replace(f"Change {name} in the head", self.declared, " ".join([*numbers, *movements]))


def split_head(text: str, tokens: Sequence[Token]) -> tuple[Head, list[Token]]:
    """Return the head of a statement and the tokens after its sign; all tokens if no sign precedes a movement."""
    sign = sign_of(tokens)
    if sign is None or (sign.type == "EQUAL" and len(tokens) == 3 and tempo_meant(tokens)):
        return Head((), None, (), (without_sign(tokens),)), list(tokens)
    if sign.type in ("BEAT", "SCENE"):
        return Head((), sign), list(tokens)
    place = tokens.index(sign)
    (*before, _), tempo = without_tempo(tokens[: place + 1])
    head = (_definition if sign.type == "EQUAL" else robots_head)(text, before, sign)
    return (dataclasses.replace(head, diagnostics=tuple(tempo)) if tempo else head), list(tokens[place + 1 :])


def sign_of(tokens: Sequence[Token]) -> Token | None:
    """Return the token that determines the kind of a statement."""
    if tokens and tokens[0].type == "SCENE":
        return tokens[0]
    for token in tokens:
        if token.type in ("EQUAL", "DOLLAR"):
            return token
    return tokens[0] if tokens and tokens[0].type == "BEAT" else None


def classified(tokens: Sequence[Token], parameters: Sequence[Parameter], hides_radius: bool = False) -> list[Token]:
    """Classify the names in a movement by their place: senses (SENSE) after words that take one, `parameters` that are
    numbers (PARAM), units (UNIT) directly behind numbers of measures, and `radius` (RADIUS) behind primitives, unless
    another meaning `hides_radius`."""
    numbers = {each.name for each in parameters if each.is_number}
    hides_radius = hides_radius or any(each.name == RADIUS for each in parameters)
    found: list[Token] = []
    before, end = "", 0
    is_measure = may_turn = False  # whether this may belong to a measure, and `radius` may follow
    for token in tokens:
        kind, text = token.type, token.text
        if kind == "NAME":
            if before in _BEFORE_SENSES:
                kind = "SENSE"
            elif text in numbers:
                kind = "PARAM"
            elif is_measure and before == "NUMBER" and text in UNITS and token.start == end:
                kind = "UNIT"
            elif may_turn and text == RADIUS and before != "OPERATOR" and not hides_radius:
                kind = "RADIUS"
        elif is_measure and before == "NUMBER" and text in UNITS and token.start == end:
            kind = "UNIT"
        found.append(token if kind == token.type else token._replace(type=kind))
        is_first = kind in ("PRIMITIVE", "RADIUS")
        is_measure = is_first or (is_measure and kind in _IN_MEASURES)
        may_turn = kind == "PRIMITIVE" or (may_turn and kind in _IN_MEASURES)
        before, end = kind, token.end
    return found


def has_measures(tokens: Sequence[Token]) -> bool:
    """Return whether a number, or `radius`, is behind a primitive."""
    before = ""
    for kind, text, _, _ in tokens:  # a loop, because every line is looked through
        if before == "PRIMITIVE" and (kind in ("NUMBER", "PARAM") or text == RADIUS):
            return True
        before = kind
    return False


def _definition(text: str, tokens: Sequence[Token], sign: Token) -> Head:
    if len(tokens) == 1 and tokens[0].type not in BRACKETS and is_name(tokens[0].text):
        return Head((Token("HEAD", *tokens[0][1:]),), sign)  # nearly all definitions
    tokens, wrong_brackets = close_brackets(tokens)
    joined = joined_touching(text, tokens)
    words = [token for token in joined if token.type not in BRACKETS]
    if not words:
        return Head((_empty_head(sign),), sign, (), (Diagnostic("syntax", sign.span, "write a name before `=`"),))
    name, *rest = joined
    if name is not words[0]:
        bare = Diagnostic("syntax", name.span, "write a name without brackets")
        return Head((words[0]._replace(type="HEAD"),), sign, (), (bare,))
    parameters, wrong = _parameters(rest)
    if not is_name(name.text):
        wrong = Diagnostic("syntax", name.span, _invalid(name))
    diagnostics = (*wrong_brackets, *([wrong] if wrong and not wrong_brackets else []))
    declared = Span(rest[0].start, rest[-1].end) if rest else None
    return Head((name._replace(type="HEAD"),), sign, tuple(parameters), diagnostics, declared)


def _parameters(tokens: Sequence[Token]) -> tuple[list[Parameter], Diagnostic | None]:
    """Read the parameters of a phrase, up to the first error."""
    parameters: list[Parameter] = []
    rest = iter(tokens)
    for token in rest:
        is_number = token.type not in BRACKETS
        name = token if is_number else next(rest)
        wrong = _wrong_parameter(token, name, parameters)
        if not wrong and not is_number:
            closer = next(rest)
            if closer.type != "RPAR":
                wrong = Diagnostic("syntax", closer.span, "write one parameter in each pair of brackets: `(a) (b)`")
        if is_name(name.text):
            parameters.append(Parameter(name, is_number))
        if wrong:
            return parameters, wrong
    return parameters, None


def _wrong_parameter(first: Token, name: Token, before: Sequence[Parameter]) -> Diagnostic | None:
    if first.type == "LSQB":
        return Diagnostic("syntax", first.span, "write a parameter that is a movement in parentheses: `(m)`")
    if name.type in BRACKETS:
        return Diagnostic("syntax", name.span, "write the name of a parameter in the brackets")
    if not is_name(name.text):
        return Diagnostic("syntax", name.span, _invalid(name))
    if first is name and before and not before[-1].is_number:
        last = before[-1].name
        return Diagnostic("syntax", name.span, f"write `{name.text}` before `({last})`: numbers come first")
    return None


def _invalid(name: Token) -> str:
    return f"`{name.text}` is not a valid name: use letters, digits, and `_`, starting with a letter or `_`"


def robots_head(text: str, tokens: Sequence[Token], sign: Token) -> Head:
    """Read the head of a statement that has robots before its sign."""
    tokens, separators = without_separators(tokens)
    joined = joined_touching(text, tokens)
    names = tuple(token._replace(type="HEAD") for token in joined if token.type not in BRACKETS)
    if not names:
        return Head(
            (_empty_head(sign),),
            sign,
            (),
            (Diagnostic("syntax", sign.span, f"write a robot's name before `{sign.text}`"),),
        )
    if len(names) < len(joined):
        wrong = next(token for token in joined if token.type in BRACKETS)
        return Head(names, sign, (), (Diagnostic("syntax", wrong.span, "write a robot's name without brackets"),))
    return Head(names, sign, (), tuple(separators))


def _empty_head(sign: Token) -> Token:
    return Token("HEAD", "", sign.start, sign.start)


def joined_touching(text: str, tokens: Sequence[Token]) -> list[Token]:
    """Join names and strays that touch into one token, so `my-robot` is one invalid name instead of three tokens."""
    joined: list[Token] = []
    for token in tokens:
        last = joined[-1] if joined else None
        if last and last.end == token.start and BRACKETS.isdisjoint({last.type, token.type}):
            joined[-1] = Token("STRAY", text[last.start : token.end], last.start, token.end)
        else:
            joined.append(token)
    return joined
