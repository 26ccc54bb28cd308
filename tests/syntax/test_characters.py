"""Characters of other keyboards: their meanings, the characters that names may have, and their names in messages."""

from __future__ import annotations

import sys
import unicodedata

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.completion import complete
from improv_core.ide.rename import RefusalError, renamable, rename
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from improv_core.syntax.characters import FULL_WIDTH, SPACES, UNSEEN, in_words, is_name, shape, spelled, usual
from improv_core.syntax.formatter import format_text
from improv_core.syntax.lexer import lex
from tests.ide.cursor import at_cursor, preferred
from tests.program.drawing import check


def test_all_spaces_and_all_full_width_signs_are_ours() -> None:
    spaces = {char for char in map(chr, range(sys.maxunicode + 1)) if unicodedata.category(char) == "Zs"}
    assert {*SPACES, " "} == spaces
    assert all(unicodedata.normalize("NFKC", full) == sign for full, sign in FULL_WIDTH.items())
    assert all(unicodedata.category(char) == "Cf" for char in UNSEEN)


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("ada ＄ repeat ４（forward　left）", "ada $ repeat 4(forward left)"),
        ("n×2÷3⁄4", "n*2/3/4"),
        ("ａ４ a４ ４a ４４ ＿a a＿b", "ａ４ a４ 4a 44 _a a＿b"),
        ("a\u200b b\u00ad, \u200dc", "a  b ,  c"),
        ("a\u200bb 1\u00ad2 for\u200dward", "a\u200bb 1\u00ad2 for\u200dward"),
        ("up ＃ ４（\u00a0\nup　left", "up # ４（\u00a0\nup left"),
        ("٤ ½ º ，", "٤ ½ º ,"),
    ],
)
def test_each_is_read_as_ours_except_in_names_and_comments(text: str, read: str) -> None:
    assert usual(text) == read
    assert len(shape(text)) == len(text)


@pytest.mark.parametrize("name", ["हिन्दी", "ไปข้างหน้า", "שָׁלוֹם", "a\u0301b", "नम\u200cस्ते", "l·l", "Ⅷ", "a４"])
def test_names_may_have_all_that_unicode_allows_in_names(name: str) -> None:
    assert is_name(name)
    assert [token.type for token in lex(f"{name} $ {name}(up)")] == [
        "NAME",
        "DOLLAR",
        "NAME",
        "LPAR",
        "PRIMITIVE",
        "RPAR",
    ]
    program = f"{name} = up left\nada $ {name}\n"
    assert analyze(program).diagnostics == ()
    assert format_text(program) == program


@pytest.mark.parametrize("text", ["\u0301a", "４a", "\u200da", "a\u200d", "a b", "a\u200bb", "·a", ""])
def test_names_begin_and_end_with_their_own_characters(text: str) -> None:
    assert not is_name(text)


def test_names_are_compared_composed_and_without_joiners() -> None:
    assert spelled("e\u0301") == spelled("é") == "é"
    assert spelled("na\u200cme\u200d\u200cs") == "names"
    assert analyze("e\u0301 = up\nada $ é").ok
    assert analyze("ada $ for\u200cward").ok


def test_two_signs_that_look_alike_stay_two_names() -> None:
    assert spelled("\u2126") != spelled("\u03a9")
    analysis = analyze("\u2126 = up\n\u03a9 = left\nada $ \u2126 \u03a9\n")
    assert [each.code for each in analysis.diagnostics] == ["two-spellings"]
    assert analysis.ok
    assert analyze("\u2126 = up\nada $ \u2126").diagnostics == ()


def test_names_of_robots_are_ascii() -> None:
    for name in ("añdá", "a\u200dda", "आगे", "ada４"):
        assert [each.code for each in analyze(f"{name} $ up").diagnostics] == ["bad-robot-name"]


def test_messages_describe_characters_in_words() -> None:
    check("""
        ada $ scale 1,5 up
                     ^ syntax: this is a comma: numbers have a point
        ada $ scale 1½ up
                     ^ unknown-name: `½` is not defined: write `3/2`: this is a vulgar fraction one half, U+00BD
        ada $ scale 50% up
                    ^^^ syntax: write `1/2` instead of `50%`
        ada $ repeat ٤ up
                     ^ syntax: write `4`: this is an arabic-indic digit four, U+0664
        ada $ scale 1e-1 up
                     ^ unknown-name: `e` is not defined: write `1/10` instead of `1e-1`
        — bow
        ^ syntax: write `---` to begin a new scene: this is an em dash, U+2014
        ada at –1 0
               ^ syntax: write `-` before a number: this is an en dash, U+2013
        ada $ left 90º
                   ^^^ missing-unit: write `90°`: this is an ordinal indicator, U+00BA, and no degree sign
        ada $ “up”
              ^ syntax: remove `“`, a left double quotation mark, U+201C: it is not part of the language
        ada $ {up left}
              ^ syntax: write `(` or `[` here: this is a curly bracket
        ada $ repeat4 up
              ^^^^^^^ unknown-name: `repeat4` is not defined: write `repeat 4`, with a space
        ada $ scale 2,000 up
                     ^ syntax: this is a comma: numbers have a point, and nothing between thousands
    """)


@pytest.mark.parametrize("char", ["\u200b", "\u00ad", "\u202e", "\u2028", "\x0c", "\x85", "\ue000", "\u2066"])
def test_no_message_has_a_bare_escape(char: str) -> None:
    for program in (
        f"ada $ for{char}ward 2{char}3",
        f"a{char}da $ up",
        f"po{char}ly n = up",
        f"ada $ {char}up",
        f"x{char}",
    ):
        for each in analyze(program).diagnostics:
            assert "\\" not in each.message
    assert in_words(char).endswith(f", U+{ord(char):04X}")


@pytest.mark.parametrize(
    ("typed", "becomes"),
    [
        ("ada $ scale 1½ up", "ada $ scale 3/2 up"),
        ("ada $ scale 1e-1 up", "ada $ scale 1/10 up"),
        ("ada $ scale 4/½ up", "ada $ scale 4/0.5 up"),
        ("ada $ scale ٣٫٥ up", "ada $ scale 3.5 up"),
        ("ada at –1 0", "ada at -1 0"),
        ("room 6×4", "room 6 4"),
        ("ada at 1,5 0,5", "ada at 1.5 0,5"),
        ("ada $ up\n—bow", "ada $ up\n--- bow"),
        ("ada $ up\u2028bo $ up # x\u2029", "ada $ up\nbo $ up # x\n"),
        ("ada $ for\u200bward", "ada $ forward"),
        ("da\u00adnce = up\nada $ dance", "dance = up\nada $ dance"),
        ("ada $ up ” left", "ada $ up  left"),
        ("ada $ up ‖ left", "ada $ up || left"),
        ("ada $ for ward", "ada $ forward"),
        ("ada $ strafe left", "ada $ strafeleft"),
        ("ada $ repeat 4 times (up left)", "ada $ repeat 4 (up left)"),
        ("p n = repeat n up\nada $ p(3)left", "p n = repeat n up\nada $ p 3 left"),
    ],
)
def test_the_preferred_fix_writes_the_only_meaning(typed: str, becomes: str) -> None:
    assert becomes in [applied(typed, edits) for edits in preferred(analyze(typed))]


@pytest.mark.parametrize(
    "typed",
    [
        "ada $ “up” left",
        "ada $ 1\u200b5 up",
        "ada $ scale 2,000 up",
        "ada $ scale 1 ½ up",
        "ada $ scale 1 1/2 up",
        "ada $ 4٤ up",
        "½ = up\nada $ scale ½ up",
        "ada $ repeat\u200bup",
        "ada $ up & left",
        "ada $ forward*2",
        "ada $ repeat4 (up left)",
        "ada $ {up left}",
        "p n = repeat n up\nada $ p 2 3 left",
        "ada $ forward (left) 0",
        "x = up canon 2 left\nada $ x",
    ],
)
def test_ambiguous_slips_have_no_preferred_fix(typed: str) -> None:
    analysis = analyze(typed)
    assert not analysis.ok
    assert preferred(analysis) == []


def test_signs_of_other_keyboards_end_and_continue_statements() -> None:
    analysis = analyze("ada ＄ （up\n　left） ＃ （\nada ＄ up\n　｜｜ left\n－－－\nx＝（up\nbo ＄ up\n")
    assert [each.text.splitlines()[0] for each in analysis.statements] == [
        "ada ＄ （up",
        "ada ＄ up",
        "－－－",
        "x＝（up",
        "bo ＄ up",
    ]


def test_a_name_is_completed_from_its_beginning() -> None:
    analysis, offset = at_cursor("आगे = up\nada $ आग|>")
    found = complete(analysis, offset)
    assert found
    assert analysis.text[slice(*found.span)] == "आग"
    assert "आगे" in [item.label for item in found.items]


def test_a_new_name_is_composed() -> None:
    analysis, offset = at_cursor("x| = up\nada $ x".replace("|", "|>"))
    symbol = renamable(analysis, offset)
    assert applied(analysis.text, rename(analysis, symbol, "e\u0301")) == "é = up\nada $ é"
    with pytest.raises(RefusalError):
        rename(analysis, symbol, "up\u200bx")


def test_a_robot_with_a_place_and_another_case_gets_a_hint() -> None:
    [problem] = analyze("Ada at 0 0\nada $ up").diagnostics
    assert problem.code == "near-name"
    assert [fix.title for fix in problem.fixes] == ["Change to ada"]
    assert analyze("Ada at 0 0\nada $ up\nAda $ up").diagnostics == ()
    assert not analyze("Ada at 0 0\nada at 1 1\nada $ up").diagnostics[0].fixes
    listed = read_robots("[robots.ada]\n[robots.Ada]\n")
    assert analyze("Ada at 0 0\nada $ up", listed).diagnostics == ()
