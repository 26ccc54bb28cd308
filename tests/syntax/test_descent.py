"""The quick parser reads exactly the movements that the grammar has, and makes the same trees of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lark import Tree, UnexpectedToken

from improv_core.syntax import derivation
from improv_core.syntax.descent import descend, descend_tempo
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Apply, Call, Choice, Node, children, numbers
from improv_core.text import Span

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
    "UNIT": "m",
    "RADIUS": "radius",
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
_RULES = {"Primitive": "word", "MeasuredWord": "measured", "Call": "name", "Parallel": "movement"}
_BEGIN = [Token("HEAD", "name", -9, -5), Token("EQUAL", "=", -3, -2)]


def check(kinds: Sequence[str]) -> bool:
    """Return whether these terminals are a movement. Fails if grammar and descent differ about it."""
    tokens = _tokens(kinds)
    body = descend(tokens)
    assert (body and _of_node(body)) == _by_grammar([*_BEGIN, *tokens]), " ".join(kinds)
    return body is not None


def _of_node(node: Node) -> list[Any]:
    """Return a tree as nested lists: a rule of the grammar, a span, the spans of arguments, and the trees inside."""
    arguments = [each.span for each in numbers(node)]
    if isinstance(node, (Apply, Choice)) and node.condition:
        arguments.append(node.condition.span)
    inside = () if isinstance(node, Call) else children(node)
    kind = type(node).__name__
    return [_RULES.get(kind, kind.lower()), node.span, arguments, [_of_node(each) for each in inside]]


def _by_grammar(tokens: Sequence[Token]) -> list[Any] | None:
    """Return the same of the movement or the number that the grammar finds at the end of a statement, if it is one."""
    parser = derivation._lark().parse_interactive()
    try:
        for token in tokens:
            parser.feed_token(token)
        statement = parser.feed_token(Token("$END", "", 0, 0))
    except UnexpectedToken:
        return None
    return _of_tree(statement.children[-1]) if isinstance(statement.children[-1], Tree) else None


def _of_tree(tree: Any) -> list[Any]:
    trees = [each for each in tree.children if isinstance(each, Tree)]
    inside = [_of_tree(each) for each in trees if each.data not in _ARGUMENTS]
    if tree.data == "series" and len(inside) == 1:
        return inside[0]
    return [tree.data, _span(tree), [_span(each) for each in trees if each.data in _ARGUMENTS], inside]


_ARGUMENTS = ("number", "measure", "condition")


def _span(tree: Any) -> Span:
    leaves = list(tree.scan_values(lambda leaf: leaf is not None))
    return Span(leaves[0].start, leaves[-1].end)


def _tokens(kinds: Sequence[str]) -> list[Token]:
    return [Token(kind, _TEXTS[kind], 10 * place, 10 * place + len(_TEXTS[kind])) for place, kind in enumerate(kinds)]


def test_all_short_sequences_of_terminals() -> None:
    movements = [kinds for length in (1, 2) for kinds in product(_TEXTS, repeat=length) if check(kinds)]
    assert ("LSQB", "RSQB") in movements
    assert not check(())


def _joined(*parts: str | st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.tuples(*(st.just(part) if isinstance(part, str) else part for part in parts)).map(" ".join)


_NUMBER = st.lists(st.sampled_from(["NUMBER", "PARAM"]), min_size=1, max_size=3).map(" OPERATOR ".join)
_MEASURE = st.lists(st.sampled_from(["NUMBER", "NUMBER UNIT", "PARAM"]), min_size=1, max_size=3).map(" OPERATOR ".join)
_CONDITION = st.sampled_from(["SENSE", "NOT SENSE"])
_LEAF = st.one_of(
    st.sampled_from(["PRIMITIVE", "NAME", "LPAR RPAR", "LSQB RSQB"]),
    _joined("PRIMITIVE", _MEASURE),
    _joined("PRIMITIVE RADIUS", _MEASURE),
    _joined("PRIMITIVE", _MEASURE, "RADIUS", _MEASURE),
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
def test_tempos_are_read_as_the_grammar_reads_them(kinds: Sequence[str]) -> None:
    number, expected = descend_tempo(_tokens(kinds)), _by_grammar(_tokens(kinds))
    assert (number and number.span) == (expected and expected[1])
