"""Colors: each word with its kind, in the order of the text."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st

from improv_core.ide.semantic_tokens import Uncolored, colored, fragments
from improv_core.ide.semantic_tokens_legend import MODIFIERS, TYPES
from improv_core.program.analysis import Analysis, analyze
from improv_core.robots.config import read_robots
from improv_core.syntax.lexer import lex


def check(program: str | Analysis, *words: str) -> None:
    """Check that these words have a color, written as `word:type` or `word:type.modifier`."""
    analysis = analyze(program) if isinstance(program, str) else program
    found = []
    for start, fragment in fragments(analysis):
        for begin, end, kind, modifiers in colored(fragment):
            kinds = [TYPES[kind], *(name for bit, name in enumerate(MODIFIERS) if modifiers >> bit & 1)]
            found.append(f"{analysis.text[start + begin : start + end]}:{'.'.join(kinds)}")
    assert found == list(words)


def test_each_kind_of_word_has_its_color() -> None:
    check(
        "beat 3/2 # slow\n# all\nx = fast 2 up\nr $ x || reflect YZ [x]",
        *("beat:modifier", "3:number", "/:operator", "2:number", "# slow:comment", "# all:comment"),
        *("x:variable.definition", "=:operator", "fast:keyword", "2:number", "up:function.defaultLibrary"),
        *("r:class", "$:operator", "x:variable", "||:operator", "reflect:keyword", "YZ:enumMember", "x:variable"),
    )


def test_unknown_words_have_no_color() -> None:
    check("r $ x\nx = x up", *("r:class", "$:operator", "x:variable.definition", "=:operator"), UP)
    robots = read_robots("[robots.anna]\n")
    check(analyze("anna ana $ up", robots), "anna:class", "$:operator", UP)


def test_units_and_radius_have_colors_only_in_measures() -> None:
    left = "left:function.defaultLibrary"
    check(
        "r $ left 90deg radius 2m",
        *("r:class", "$:operator", left, "90:number", "deg:number", "radius:keyword", "2:number", "m:number"),
    )
    check("m = up\nr $ fast 2m", *("m:variable.definition", "=:operator", UP, "r:class", "$:operator"), *FAST_M)
    check(
        "radius = up\nr $ left radius fast 2 radius",
        *("radius:variable.definition", "=:operator", UP, "r:class", "$:operator", left, "radius:variable"),
        *("fast:keyword", "2:number", "radius:variable"),
    )
    check("room 6m 4", "room:keyword", "6:number", "m:number", "4:number")


FAST_M = ("fast:keyword", "2:number", "m:variable")


def test_senses_are_colored_as_properties() -> None:
    check(
        "near = up\nr $ until near near if not cue near else up pause fire up",
        *("near:variable.definition", "=:operator", UP, "r:class", "$:operator"),
        *("until:keyword", "near:property", "near:variable"),
        *("if:keyword", "not:keyword", "cue:property", "near:variable", "else:keyword", UP, "pause:keyword", UP),
    )
    check("r $ until # near\n", "r:class", "$:operator", "until:keyword", "# near:comment")


def test_words_for_body_parts_and_poses_unless_a_name_hides_them() -> None:
    check(
        "ada is puppet\nada $ head left to high arms to start",
        *("ada:class", "is:keyword", "puppet:enumMember", "ada:class", "$:operator"),
        *("head:keyword", "left:function.defaultLibrary", "to:keyword", "high:enumMember"),
        *("arms:keyword", "to:keyword", "start:enumMember"),
    )
    check(
        "head = up\nf to = to up\nada $ head",
        *("head:variable.definition", "=:operator", UP),
        *("f:variable.definition", "to:parameter.definition", "=:operator", "to:parameter", UP),
        *("ada:class", "$:operator", "head:variable"),
    )


def test_parameters_in_the_head_and_in_the_body() -> None:
    check(
        "f n (m) = fast n/2 m\n---",
        *("f:variable.definition", "n:parameter.definition", "m:parameter.definition", "=:operator"),
        *("fast:keyword", "n:parameter", "/:operator", "2:number", "m:parameter", "---:operator"),
    )
    check("f f = f", "f:variable.definition", "f:parameter.definition", "=:operator", "f:parameter")


UP = "up:function.defaultLibrary"


def test_broken_statements_keep_their_colors() -> None:
    check("r $ (up ||", "r:class", "$:operator", UP, "||:operator")
    check("my-robot $ ) 7 ? up", "$:operator", "7:number", UP)
    check("x = up\nx up", "x:variable.definition", "=:operator", UP, "x:variable", UP)
    check("up = up", UP, "=:operator", UP)


def test_only_what_is_in_sight() -> None:
    text = "# one\nr $ up\n# two\ns $ up\n# three\n"
    found = [fragment.text for _, fragment in fragments(analyze(text), text.index("up"), text.index("s"))]
    assert found == ["r $ up", "# two", "s $ up"]


@given(st.lists(st.sampled_from([*"rx$=|(]-+?#😀 \n\ufeff", "up ", "beat", "||", ".5", "3/2", "1x"])).map("".join))
def test_only_tokens_and_comments_have_a_color(text: str) -> None:
    found = {(start, end) for start, end, *_ in colored(Uncolored(text))}
    comments = {comment.span() for comment in re.finditer(r"#[^\r\n]*", text)}
    tokens = {token.span: token.type for token in lex(text)}
    assert found <= comments | set(tokens)
    colorless = {span for span, kind in tokens.items() if kind in ("LPAR", "RPAR", "LSQB", "RSQB", "STRAY", "NAME")}
    assert comments | set(tokens) <= found | colorless
