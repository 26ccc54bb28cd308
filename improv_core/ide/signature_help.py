"""Signature help: the parameters of the transformer at the cursor, and which one is being typed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from improv_core.ide.cursor import before
from improv_core.program.analysis import Analysis
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import WORDS, Kind
from improv_core.text import Span

_ARGUMENTS = {
    Kind.REPEAT: "n",
    Kind.REFLECT: "PLANE",
    Kind.FACTOR: "k",
    Kind.PLAIN: "",
    Kind.RAMP: "a b",
    Kind.GUARD: "sense",
}
_TRANSFORMERS = {kind.value for kind in _ARGUMENTS}


@dataclass(frozen=True, slots=True)
class Signature:
    """How a transformer is written, its parameters as spans of the label, and the index of the one being typed."""

    label: str
    about: str
    parameters: tuple[Span, ...]
    active: int


def signature(analysis: Analysis, offset: int) -> Signature | None:
    """The innermost transformer whose number, plane, or movement is being typed at the cursor."""
    found = before(analysis, offset)
    if not found:
        return None
    sign = next((place for place, token in enumerate(found.tokens) if token.type in ("EQUAL", "DOLLAR")), None)
    if sign is None:
        return None
    open_words = _open(found.tokens[sign + 1 :])
    if not open_words:
        return None
    word, has_argument = open_words[-1]
    kind = WORDS[word.text].kind
    parameters = [name for name in (_ARGUMENTS[kind], "movement") if name]
    # `repeat` needs no number: if a word has been started, it is the movement.
    skipped = kind is Kind.REPEAT and found.begun and not found.in_number
    in_argument = found.tokens[-1] == word and not has_argument and not skipped
    active = 0 if in_argument else len(parameters) - 1
    return _signature(word.text, parameters, active)


def _signature(word: str, parameters: Sequence[str], active: int) -> Signature:
    label, spans = word, []
    for name in parameters:
        spans.append(Span(len(label) + 1, len(label) + 1 + len(name)))
        label = f"{label} {name}"
    return Signature(label, WORDS[word].about, tuple(spans), active)


def _open(tokens: Sequence[Token]) -> list[tuple[Token, bool]]:
    """The transformers whose movement is not complete, outermost first, and whether they have their argument."""
    levels: list[list[tuple[Token, bool]]] = [[]]  # one for each open bracket
    for token in tokens:
        waiting = levels[-1]
        if token.type in _TRANSFORMERS:
            waiting.append((token, False))
        elif token.type in ("NUMBER", "OPERATOR", "PLANE"):
            if waiting:
                waiting[-1] = (waiting[-1][0], True)
        elif token.type in ("LPAR", "LSQB"):
            levels.append([])
        elif token.type in ("RPAR", "RSQB"):
            if len(levels) > 1:
                levels.pop()
            levels[-1].clear()
        else:
            waiting.clear()  # a movement or `||`: all that waited for a movement have one
    return [each for waiting in levels for each in waiting]
