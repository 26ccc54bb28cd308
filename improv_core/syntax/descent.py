"""Parse correct movements by recursive descent, in a fraction of the time that the grammar takes."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import lru_cache
from itertools import chain

from improv_core.score.algebra import hold
from improv_core.slices import checkpoint
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import (
    Apply,
    Bracket,
    Call,
    Choice,
    Condition,
    MeasuredWord,
    Missing,
    Name,
    Node,
    Number,
    Parallel,
    Primitive,
    Series,
)
from improv_core.syntax.vocabulary import TRANSFORMERS, WORDS
from improv_core.text import Span
from improv_core.values import Shared

DEEPEST = 200
"""The most levels of nested brackets and transformers."""
AT_ONCE = 100
"""Terms between two places where parsing can be interrupted: less than a millisecond."""
SHORT = 3
"""The most tokens of a number that all statements share: `3/2` has as many."""


class TooDeepError(Exception):
    """Movements are nested too deeply at `span`."""

    def __init__(self, span: Span) -> None:
        super().__init__(f"this is nested more than {DEEPEST} levels deep: name a part and use the name")
        self.span = span


def descend(tokens: Sequence[Token]) -> Node | None:
    """Return the movement of these tokens. None if they are not exactly one: then the grammar finds the error.

    A test compares this with the grammar. It recurses once for each level of brackets and transformers. Raises
    TooDeepError.
    """
    try:
        return _Descent(tokens).movement(_END)
    except _UnexpectedError:
        return None


def descend_tempo(tokens: Sequence[Token]) -> Number | None:
    """Return the number of `beat n`; None if these tokens are anything else."""
    descent = _Descent(tokens)
    try:
        descent.take(("BEAT",))
        number = descent.number()
    except _UnexpectedError:
        return None
    return number if descent.next is _AFTER_LAST else None


_SPANS = Shared(Span, 20_000)
SAME = Shared(Token, 20_000)
"""Tokens that all statements share: words and signs are alike in most of them."""


@lru_cache(maxsize=20_000)
def _primitive(text: str, start: int, end: int) -> Primitive:
    """Return the node of this word at this offset. All statements share it, because most nodes are primitives."""
    place, word = _SPANS[start, end], WORDS[text]
    return Primitive(place, word, hold(word.velocity, span=place))


def number_of(factors: Sequence[Token]) -> Number:
    """Return a number, or a product: its factors, with the operators between them. All statements share short ones."""
    return _short_number(*factors) if len(factors) <= SHORT else _number(*factors)


def _number(*factors: Token) -> Number:
    return Number(_SPANS[factors[0].start, factors[-1].end], "".join([token.text for token in factors]), factors)


_short_number = lru_cache(maxsize=20_000)(_number)


_END = "$END"
_AFTER_LAST = Token(_END, "", 0, 0)
_FACTORS = frozenset({"NUMBER", "PARAM"})
_BEHIND_WORDS = frozenset({*_FACTORS, "RADIUS"})
_MEASURES = ("UNIT",)
_NUMBERS = {"REPEAT": 1, "FACTOR": 1, "RAMP": 2}


class _UnexpectedError(Exception):
    """A token that does not fit."""


class _Descent:
    """Reads tokens from left to right. `next` is the first one not yet read."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self._rest = chain(tokens, (_AFTER_LAST,))
        self._depth = 0
        self.next = next(self._rest)

    def take(self, kinds: Collection[str]) -> Token:
        """Return the next token, which must be one of these kinds."""
        token = self.next
        if token.type not in kinds:
            raise _UnexpectedError
        self.next = next(self._rest)
        return token

    def movement(self, end: str) -> Node:
        """Read voices up to a token of the kind `end`, which is not read."""
        first = self.voice()
        if self.next.type != "BAR":
            if self.next.type != end:
                raise _UnexpectedError
            return first
        voices = [first]
        while self.next.type == "BAR":
            self.next = next(self._rest)
            voices.append(self.voice())
            if not len(voices) % AT_ONCE:
                checkpoint()
        if self.next.type != end:
            raise _UnexpectedError
        return Parallel(_SPANS[first.span.start, voices[-1].span.end], tuple(voices))

    def voice(self) -> Node:
        terms = [self.term()]
        while self.next.type not in _AFTER_A_VOICE:
            terms.append(self.term())
            if not len(terms) % AT_ONCE:
                checkpoint()
        return terms[0] if len(terms) == 1 else Series(_SPANS[terms[0].span.start, terms[-1].span.end], tuple(terms))

    def term(self) -> Node:
        token = self.next
        if token is _AFTER_LAST:
            raise _UnexpectedError
        kind, text, start, end = token
        self.next = next(self._rest)
        if kind == "PRIMITIVE":
            word = _primitive(text, start, end)
            return word if self.next.type not in _BEHIND_WORDS else self._measured(word)
        if kind == "NAME":
            name = Name(_SPANS[start, end], text)
            if self.next.type not in _FACTORS:
                return name
            numbers = [self.number()]
            while self.next.type in _FACTORS:
                numbers.append(self.number())
            return Call(_SPANS[start, numbers[-1].span.end], name, tuple(numbers))
        if kind == "MISSING":
            return Missing(_SPANS[start, end])
        if kind not in _NESTING:
            raise _UnexpectedError
        self._depth += 1
        if self._depth > DEEPEST:
            raise TooDeepError(token.span)
        node = self._nested(token)
        self._depth -= 1
        return node

    def _nested(self, token: Token) -> Node:
        kind, start = token.type, token.start
        if kind in _CLOSERS:
            closer = _CLOSERS[kind]
            body = None if self.next.type == closer else self.movement(closer)
            return Bracket(_SPANS[start, self.take((closer,)).end], kind == "LSQB", body)
        if kind == "IF":
            condition, then = self.condition(), self.voice()
            self.take(("ELSE",))
            otherwise = self.term()
            return Choice(_SPANS[start, otherwise.span.end], token, condition, then, otherwise)
        has_numbers = kind in _NUMBERS and (kind != "REPEAT" or self.next.type in _FACTORS)
        numbers = tuple([self.number() for _ in range(_NUMBERS[kind])]) if has_numbers else ()
        plane = SAME[self.take(("PLANE",))] if kind == "REFLECT" else None
        guard = self.condition() if kind == "GUARD" else None
        body = self.term()
        return Apply(_SPANS[start, body.span.end], SAME[token], body, numbers, plane, guard)

    def _measured(self, word: Primitive) -> MeasuredWord:
        measure = self.number(_MEASURES) if self.next.type in _FACTORS else None
        radius = None
        if self.next.type == "RADIUS":
            self.next = next(self._rest)
            radius = self.number(_MEASURES)
        last = radius or measure
        assert last
        return MeasuredWord(_SPANS[word.span.start, last.span.end], word, measure, radius)

    def number(self, units: Collection[str] = ()) -> Number:
        factors = [SAME[self.take(_FACTORS)]]
        while self.next.type == "OPERATOR" or self.next.type in units:
            factors.append(SAME[self.take(("OPERATOR", "UNIT"))])
            if factors[-1].type == "OPERATOR":
                factors.append(SAME[self.take(_FACTORS)])
            elif factors[-2].type != "NUMBER":
                raise _UnexpectedError
        return number_of(factors)

    def condition(self) -> Condition:
        found = [self.take(("SENSE", "NOT"))]
        if found[0].type == "NOT":
            found.append(self.take(("SENSE",)))
        return Condition(_SPANS[found[0].start, found[-1].end], len(found) > 1, found[-1])


_CLOSERS = {"LPAR": "RPAR", "LSQB": "RSQB"}
_NESTING = frozenset({*_CLOSERS, "IF", *(kind.value for kind in TRANSFORMERS)})
_AFTER_A_VOICE = frozenset({"BAR", "RPAR", "RSQB", "ELSE", _END})
