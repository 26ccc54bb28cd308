"""Robots and profiles in an improv.toml: found, with all their names, and renamed."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.rename import RefusalError
from improv_core.ide.robots_file.body_names import rename_in_file, rename_in_program
from improv_core.ide.robots_file.references import declarations, rename_profile, symbol_at, uses
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots

TEXT = """\
[profiles.rover]
step = 0.5
[profiles.fast]
base = "rover"
[robots.anna]
profile = 'rover'
[robots.bert]
profile = "husky"
[robots.anna.start]
x = 1
"""


def check(word: str, expected: str, nth: int = 0) -> None:
    """Check the lines of all names of the symbol at the cursor; a use is in brackets."""
    offset = -1
    for _ in range(nth + 1):
        offset = TEXT.index(word, offset + 1)
    symbol = symbol_at(TEXT, offset + 1)
    assert symbol
    declared = [str(TEXT.count("\n", 0, span.start)) for span in declarations(TEXT, symbol)]
    used = [f"({TEXT.count(chr(10), 0, span.start)})" for span in uses(TEXT, symbol)]
    assert " ".join([symbol.section, symbol.name, *declared, *used]) == expected


def test_all_names_of_a_robot_or_profile() -> None:
    check("rover", "profiles rover 0 (3) (5)")
    check("rover", "profiles rover 0 (3) (5)", nth=2)
    check("anna", "robots anna 4 8")
    assert symbol_at(TEXT, TEXT.index("step")) is None


def renamed(text: str, word: str, new: str) -> str:
    symbol = symbol_at(text, text.index(word))
    assert symbol
    return applied(text, rename_profile(text, symbol, new))


def test_a_profile_is_renamed_with_its_uses() -> None:
    assert renamed(TEXT, "rover", "cart") == TEXT.replace("rover", "cart")
    assert renamed(TEXT, "rover", "rover") == TEXT


@pytest.mark.parametrize(
    ("text", "word", "new", "why"),
    [
        (TEXT, "rover", "husky", "`husky` is already a profile: choose another name"),
        (TEXT, "rover", "a b", "`a b` is not a valid profile name: use a to z, digits, `_`, and `-`"),
        (TEXT, "husky", "a", "`husky` is built in and can't be renamed"),
        (TEXT + "[", "rover", "a", "improv.toml can't be read: fix it first"),
    ],
)
def test_a_refused_rename_says_why(text: str, word: str, new: str, why: str) -> None:
    with pytest.raises(RefusalError) as refusal:
        renamed(text, word, new)
    assert str(refusal.value) == why


BODY = """\
[profiles.dog]
step = 1
[profiles.dog.body.l_ear]
mirror = "r_ear"
up = { joint = "le", degrees = 30 }
poses.pricked = { up = 30 }
[profiles.dog.body.r_ear]
up = { joint = "re", degrees = 30 }
[profiles.dog.body.ears]
parts = ["l_ear", "r_ear"]
[profiles.pup]
base = "dog"
[profiles.pup.body.l_ear.poses]
pricked = { up = 20 }
[profiles.pup.body.l_ear.up]
joint = "le"
degrees = 9
[robots.rex]
profile = "dog"
"""


def renamed_with_programs(word: str, new: str, program: str, text: str = BODY) -> tuple[str, str]:
    symbol = symbol_at(text, text.index(word) + 1)
    assert symbol
    edits, profiles = rename_in_file(text, symbol, new)
    analysis = analyze(program, read_robots(text))
    return applied(text, edits), applied(program, rename_in_program(analysis, symbol, new, profiles))


def test_a_body_part_is_renamed_in_all_profiles_and_where_programs_use_it() -> None:
    program = "x = l_ear (up down)\nrex $ x ears to pricked l_ear r_ear up\nl_ear = left\nrex $ l_ear\n"
    assert renamed_with_programs("l_ear", "ear", program) == (
        BODY.replace("l_ear", "ear"),
        "x = ear (up down)\nrex $ x ears to pricked ear r_ear up\nl_ear = left\nrex $ l_ear\n",
    )
    assert renamed_with_programs("ears", "both", "rex $ ears up\n") == (BODY.replace("ears", "both"), "rex $ both up\n")
    assert renamed_with_programs("r_ear", "è", "rex $ r_ear up\n")[1] == "rex $ è up\n"
    assert renamed_with_programs("l_ear", "l_ear", "rex $ l_ear up\n") == (BODY, "rex $ l_ear up\n")


def test_a_pose_is_renamed_but_not_a_name_like_it() -> None:
    program = "pricked = l_ear to pricked\nrex $ pricked ears (to start to pricked)\n"
    assert renamed_with_programs("pricked", "tall", program) == (
        BODY.replace("pricked", "tall"),
        "pricked = l_ear to tall\nrex $ pricked ears (to start to tall)\n",
    )


@pytest.mark.parametrize(
    ("word", "new", "program", "why"),
    [
        ("l_ear", "r_ear", "", "`r_ear` is already a body part: choose another name"),
        ("l_ear", "head", "", "`head` is already a body part: choose another name"),  # a puppet has it
        ("l_ear", "left", "", "`left` is a word of the language: choose another name for this body part"),
        ("pricked", "start", "", "`start` is a word of the language: choose another name for this pose"),
        ("pricked", "high", "", "`high` is already a pose: choose another name"),
        ("l_ear", "x", "x = up\nrex $ l_ear x\n", "`x` is already defined on line 1: choose another name"),
        ("l_ear", "x", "y (x) = l_ear x\nrex $ y up\n", "`x` is a parameter on line 1: choose another name"),
    ],
)
def test_a_rename_of_a_body_part_that_is_refused(word: str, new: str, program: str, why: str) -> None:
    with pytest.raises(RefusalError) as refusal:
        renamed_with_programs(word, new, program)
    assert str(refusal.value) == why


def test_a_word_that_a_puppet_performs_too_is_renamed_by_hand() -> None:
    text = BODY.replace("l_ear", "head")
    assert renamed_with_programs("head", "ear", "ada is puppet\nrex $ head up\n", text)[1].endswith("rex $ ear up\n")
    with pytest.raises(RefusalError, match="on line 2, `head` is also that of the profile puppet: rename it by hand"):
        renamed_with_programs("head", "ear", "ada is puppet\nrex ada $ head up\n", text)


def test_a_body_part_is_not_renamed_in_a_file_with_an_error() -> None:
    with pytest.raises(RefusalError, match=r"improv\.toml has an error: fix it first"):
        renamed_with_programs("l_ear", "ear", "", BODY.replace('"r_ear"\n', '"r"\n'))
