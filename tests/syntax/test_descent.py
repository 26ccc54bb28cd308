"""The quick parser reads exactly the movements that the grammar has, and makes the same trees of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.syntax.descent import descend, descend_tempo
from improv_core.syntax.heads import Head
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Parameter
from improv_core.syntax.parser import parse_and_repair

_TEXTS = {
    "PRIMITIVE": "forward",
    "NAME": "a",
    "PLAIN": "reverse",
    "REPEAT": "repeat",
    "REFLECT": "reflect",
    "PLANE": "YZ",
    "FACTOR": "fast",
    "RAMP": "ramp",
    "GUARD": "until",
    "IF": "if",
    "ELSE": "else",
    "NOT": "not",
    "SENSE": "cue",
    "NUMBER": "2",
    "PARAM": "n",
    "OPERATOR": "*",
    "BAR": "||",
    "STRAY": "?",
    "LPAR": "(",
    "RPAR": ")",
    "LSQB": "[",
    "RSQB": "]",
    "EQUAL": "=",
    "SCENE": "---",
    "BEAT": "beat",
}
_N = Token("HEAD", "n", 5, 6)
_HEAD = Head((Token("HEAD", "name", 0, 4),), Token("EQUAL", "=", 7, 8), (Parameter(_N, True),), (), _N.span)


def check(kinds: Sequence[str]) -> bool:
    """Return whether these terminals are a movement. Fails if grammar and descent differ about it."""
    tokens = _tokens(kinds)
    body, _, wrong = parse_and_repair(tokens, _HEAD)
    assert descend(tokens) == (None if wrong else body), " ".join(kinds)
    return not wrong


def _tokens(kinds: Sequence[str]) -> list[Token]:
    return [Token(kind, _TEXTS[kind], 10 * place, 10 * place + len(_TEXTS[kind])) for place, kind in enumerate(kinds)]


def test_all_short_sequences_of_terminals() -> None:
    movements = [kinds for length in (1, 2) for kinds in product(_TEXTS, repeat=length) if check(kinds)]
    assert ("LSQB", "RSQB") in movements
    assert not check(())


def _joined(*parts: str | st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.tuples(*(st.just(part) if isinstance(part, str) else part for part in parts)).map(" ".join)


_NUMBER = st.lists(st.sampled_from(["NUMBER", "PARAM"]), min_size=1, max_size=3).map(" OPERATOR ".join)
_CONDITION = st.sampled_from(["SENSE", "NOT SENSE"])
_LEAF = st.one_of(
    st.sampled_from(["PRIMITIVE", "NAME", "LPAR RPAR", "LSQB RSQB"]),
    _joined("NAME", st.lists(_NUMBER, min_size=1, max_size=3).map(" ".join)),
)


def _larger(term: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    voice = st.lists(term, min_size=1, max_size=4).map(" ".join)
    body = st.lists(voice, min_size=1, max_size=3).map(" BAR ".join)
    return st.one_of(
        _joined("LPAR", body, "RPAR"),
        _joined("LSQB", body, "RSQB"),
        _joined("PLAIN", term),
        _joined("REPEAT", term),
        _joined("REPEAT", _NUMBER, term),
        _joined("REFLECT PLANE", term),
        _joined("FACTOR", _NUMBER, term),
        _joined("RAMP", _NUMBER, _NUMBER, term),
        _joined("GUARD", _CONDITION, term),
        _joined("IF", _CONDITION, voice, "ELSE", term),
        body,
    )


_MOVEMENT = st.recursive(_LEAF, _larger, max_leaves=12).map(str.split)


@given(_MOVEMENT)
@settings(deadline=None)
def test_long_sequences_are_read_alike(kinds: list[str]) -> None:
    check(kinds)


@given(_MOVEMENT, st.data())
@settings(deadline=None)
def test_sequences_with_a_change_are_read_or_refused_alike(kinds: list[str], data: st.DataObject) -> None:
    place = data.draw(st.integers(0, len(kinds) - 1))
    check([*kinds[:place], *data.draw(st.lists(st.sampled_from(list(_TEXTS)), max_size=2)), *kinds[place + 1 :]])


@pytest.mark.parametrize("kinds", [("BEAT", "NUMBER"), ("BEAT",), ("BEAT", "NUMBER", "OPERATOR", "NUMBER")])
def test_tempos(kinds: Sequence[str]) -> None:
    head = Head((), Token("BEAT", "beat", 0, 4))
    _, number, wrong = parse_and_repair(_tokens(kinds), head)
    assert descend_tempo(_tokens(kinds)) == (None if wrong else number)
