"""The opening: the places and kinds of robots, the floor, the bar, and names of scenes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.diagnostics import Severity
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.robots.config import read_robots
from improv_core.score.senses import BUILT_IN as SENSES
from improv_core.syntax.formatter import format_text
from improv_core.syntax.lexer import lex
from tests.program.drawing import check
from tests.program.test_slips import check_fixes

ROOT = Path(__file__).parents[2]
CASES: list[dict[str, Any]] = json.loads((ROOT / "tests" / "conformance.json").read_text())["cases"]
LEGAL = [case["program"] for case in CASES if case["source"] != "language 3" and "senses" not in case]
EXAMPLES = [path.read_text() for path in sorted((ROOT / "examples").rglob("*.improv"))]
LEGAL += [each for each in EXAMPLES if analyze(each).openings == analyze(each).scenes]
WORDS = ("at", "is", "room", "bar", "circle", "line", "grid", "facing", "in", "out", "around")


def starts(analysis: Analysis) -> dict[str, list[float]]:
    return {name: [round(each, 3) for each in robot["start"]] for name, robot in compiled(analysis)["robots"].items()}


@given(st.sampled_from(LEGAL), st.permutations(WORDS))
def test_names_may_be_words_of_the_opening(program: str, words: list[str]) -> None:
    names = dict.fromkeys(token.text for token in lex(program) if token.type == "NAME" and token.text not in SENSES)
    called = dict(zip(names, words, strict=False))
    text = program
    for token in reversed(lex(program)):
        if token.type == "NAME" and token.text in called:
            text = text[: token.start] + called[token.text] + text[token.end :]
    before, after = analyze(program), analyze(text)
    assert after.openings == before.scenes
    assert errors(after) == errors(before)
    found, wanted = compiled(after, 100), compiled(before, 100)
    assert found == {**wanted, "robots": {called.get(name, name): each for name, each in wanted["robots"].items()}}
    assert analyze(format_text(text)).openings == after.openings


def errors(analysis: Analysis) -> list[str]:
    return [each.code for each in analysis.diagnostics if each.severity is Severity.ERROR]


@pytest.mark.parametrize(
    "line",
    ["bar 3", "bar", "room at 1", "at at 1 2", "line 4 left", "is is is", "--- a"],
)
def test_a_line_of_the_opening_begins_a_statement_only_outside_brackets(line: str) -> None:
    inside = analyze(f"bar n = repeat n left\nr $ (\n  {line}\n)\n")
    assert inside.openings == [] or line.startswith("---")
    assert not analyze(f"r $ (\n  left {line}").opening.places


def test_a_line_with_a_sign_is_never_one_of_these() -> None:
    check("""
        at = forward
        is room bar $ at
        room at $ forward
        bar 3 $ left
            ^ bad-robot-name: `3` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        ada at 1 2 = left
               ^ syntax: `1` is not a valid name: use letters, digits, and `_`, starting with a letter or `_`
        --- r $ left
            ^ syntax: remove `r` or start a new line before it
    """)


def test_robots_may_be_called_like_the_words() -> None:
    analysis = check("""
        at at at line 2
           ^^ duplicate-line: this line already places `at`: remove it here
        is circle at line 2
        at is is quadrotor
        room is quadrotor
        room bar at grid 1 around 9 9
    """)
    assert list(analysis.opening.places) == ["at", "is", "circle", "room", "bar"]
    assert set(analysis.opening.config.kinds) == {"at", "is", "room"}


def test_the_first_at_before_a_place_is_the_sign() -> None:
    check("""
        a at circle at 1 2
                    ^^ syntax: write the radius of the circle, in meters: `circle 1.5`
        a at 1 2 at circle 3
                 ^^^^^^^^^^^ syntax: remove `at` or start a new line before it
    """)


def test_missing_and_extra_words_are_reported() -> None:
    check("""
        room 6
             ^ syntax: write the floor's length along x and along y, in meters: `room 6 4`
        room 6, 4
              ^ syntax: remove `,`: separate numbers with spaces
        room 6x4
              ^^ syntax: separate the two lengths with a space: `room 6 4`
        room 6 4 2
                 ^ syntax: remove `2` or start a new line before it
        room -6 4
             ^^ syntax: write `6` without a sign: this number is above 0
        bar 3/
             ^ syntax: write a number after `/`
        bar 3 - 1
              ^^^ syntax: remove `-` or start a new line before it
        ada at 1
               ^ syntax: write x and y in meters after `at`: `ada at 1 0.5`
        ada at circle
               ^^^^^^ syntax: write the radius of the circle, in meters: `circle 1.5`
        ada at 1, 2
                ^ syntax: remove `,`: separate numbers with spaces
        ada at (1, 2)
               ^^^^^^ syntax: write x and y in meters after `at`: `ada at 1 0.5`
        at 1 2
        ^^ syntax: write a robot's name before `at`
        ada at home
               ^^^^ syntax: write x and y in meters after `at`: `ada at 1 0.5`, or `circle`, `line`, or `grid`
        ada at 1 2 facing
                   ^^^^^^ syntax: write degrees after `facing`, counterclockwise from the x axis: `facing 90`
        ada at 1 2 facing in
                          ^^ syntax: write degrees after `facing`, counterclockwise from the x axis: `facing 90`
        ada at 1e300 0
                ^^^^ syntax: write x and y in meters after `at`: `ada at 1 0.5`
        ada at 1 2/-1
                   ^^ syntax: write a sign before the first number only
        ada bo at 1 2
        ^^^^^^ syntax: only one robot can stand at a point: write `line 1 around 1 2`, or a line for each robot
        ada bo at line
                  ^^^^ syntax: write the distance between neighbors, in meters: `line 1`
        ada bo at grid -1
                       ^^ syntax: write `1` without a sign: this number is above 0
        ada bo at line 1 facing in
                         ^^^^^^ syntax: `facing` works only with `circle`: remove it from this line
        ada bo at circle 1 facing 90
                                  ^^ syntax: write `in` or `out` after `facing`
        ada bo at circle 1 around 1 around 2 3
                                    ^^^^^^ syntax: write x and y of the middle, in meters: `around 2 0`
        ada bo at circle 1 facing in facing out
                                     ^^^^^^ syntax: write `facing` once only
        ada, bo at circle 1
           ^ syntax: separate robots with spaces, without `,`
        ada is
            ^^ syntax: write a profile after `is`: `ada is turtlesim`
        ada is a husky
               ^^^^^^^ syntax: write only the name of a profile after `is`
        --- one two
                ^^^ syntax: write one name after `---`, such as `one_two`
        --- 2
            ^ syntax: `2` can't name a scene: use letters, digits, and `_`, starting with a letter
    """)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("room 6", ["room 6 6"]),
        ("room 6x4", ["room 6 4"]),
        ("room -6 4", ["room 6 4"]),
        ("room 6 4 2", []),
        ("ada at 1", ["ada at 1 0"]),
        ("ada at 1,2", ["ada at 1 2"]),
        ("ada at (1, 2)", ["ada at 1 2"]),
        ("ada at circle", ["ada at circle 1.5"]),
        ("ada at circle 1 facing", ["ada at circle 1 facing in"]),
        ("ada bo at circel 2", ["ada bo at circle 2"]),
        ("ada at 1 2 facng 90", ["ada at 1 2 facing 90"]),
        ("ada bo at 1 2", ["ada bo at line 1 around 1 2"]),
        ("ada bo at line 1 facing in", ["ada bo at line 1"]),
        ("r $ left\n--- one two\nr $ up", ["r $ left\n--- one_two\nr $ up"]),
        ("bar 3\nbar 4", ["bar 3\n"]),
        ("ada bo at line 1\nbo cy at line 2", ["ada bo at line 1\ncy at line 2"]),
        (
            "r $ left\n--- a\nr $ left\n--- a\nr $ left",
            ["r $ left\n--- a\nr $ left\n--- a2\nr $ left", "r $ left\n--- a\nr $ left\n---\nr $ left"],
        ),
        ("ada is turtlebot5", ["ada is turtlebot4"]),
        ("left at 1 2", ["my_left at 1 2"]),
    ],
)
def test_fixes_write_correct_lines(before: str, after: list[str]) -> None:
    check_fixes(before, *after)


def test_numbers_are_in_their_ranges() -> None:
    check("""
        room 0 4
             ^ bad-number: write this length as a number above 0
        room 6 1/0
        ^^^^^^^^^^ duplicate-line: line 1 already sets the floor: remove this line
               ^^^ bad-number: write this length without dividing by 0
        bar 0
            ^ bad-number: write this as a whole number of beats, from 1 to 1,000
        ada at 1000 -1000 facing 100000
        bo at 1001 0
              ^^^^ bad-number: write this place in meters, from -1,000 to 1,000
        cy at 0 -1001
                ^^^^^ bad-number: write this place in meters, from -1,000 to 1,000
        dan at 0 0 facing 1/0
                          ^^^ bad-number: write this angle without dividing by 0
        eve at circle 0
                      ^ bad-number: write this radius as a number above 0
        fay at grid 1001
                    ^^^^ bad-number: write this distance in meters, up to 1,000
        gus at line 1 around 9999 0
                             ^^^^ bad-number: write this place in meters, from -1,000 to 1,000
    """)
    for bar in ("3/2", "1001", "1/2"):
        assert [each.code for each in analyze(f"bar {bar}").diagnostics] == ["bad-number"]
    for number in ("1" + "0" * 300, "0." + "0" * 300 + "1"):
        assert [each.code for each in analyze(f"ada at {number} 0").diagnostics] == ["bad-number"]


def test_robots_of_the_opening_are_checked_like_all_others() -> None:
    toml = "[robots.ada]\nprofile = 'husky'\n[robots.bo]\n[robots.cy]\nprofile = 'jackal'\n"
    check(
        """
        ada bo cyy at circle 2
               ^^^ unknown-robot: `cyy` is not in improv.toml: did you mean `cy`?
        left at 1 2
        ^^^^ reserved-name: `left` is a reserved word: choose another name
        ada and bo is husky
        ^^^ no-effect: `ada` is already a `husky` in improv.toml: remove it here
            ^^^ unknown-robot: this makes a robot called `and`: separate robots with spaces only
        cy is husky
        ^^ other-profile: `cy` is a `jackal` in improv.toml, which counts: change it there
        up is husky
        ^^ reserved-name: `up` is a reserved word: choose another name
        --- up
            ^^ reserved-name: `up` is a reserved word: choose another name
        bo is huskyy
        ^^^^^^^^^^^^ duplicate-line: line 3 already gives `bo` a profile: remove this line
              ^^^^^^ unknown-profile: `huskyy` is not a profile: did you mean `husky`?
        ada $ forward
        """,
        hints=True,
        robots=toml,
    )


def test_a_kind_counts_if_improv_toml_sets_none() -> None:
    toml = "[robots.ada]\nprofile = 'husky'\n[robots.bo]\nmessage = 'TwistStamped'\n[profiles.nao-v6]\nstep = 0.4\n"
    analysis = check(
        """
        ada bo is nao-v6
        ^^^ other-profile: `ada` is a `husky` in improv.toml, which counts: change it there
        ada bo $ forward
        """,
        robots=toml,
    )
    parts = score_of(analysis).parts
    assert [parts[name].profile.name for name in ("ada", "bo")] == ["husky", "nao-v6"]
    assert parts["bo"].profile.message == "TwistStamped"


def test_a_change_of_kind_checks_movements_again() -> None:
    analysis = analyze("ada is quadrotor\nada $ strafeleft\n")
    assert analysis.ok
    changed = analysis.edited(7, 16, "turtlebot4")
    assert [each.code for each in changed.diagnostics] == ["unsupported-direction"]
    assert changed.edited(7, 17, "quadrotor").ok
    assert changed.edited(0, 18, "").ok


def test_a_definition_edited_into_a_line_of_the_opening_defines_nothing() -> None:
    analysis = analyze("bar = forward\nr $ bar\n")
    assert [each.code for each in analysis.edited(4, 13, "3").diagnostics] == ["unknown-name"]


def test_the_program_wins_over_improv_toml() -> None:
    toml = "[robots.ada]\nstart = { x = 5 }\n[robots.bo]\nstart = { x = 7 }\n"
    toml += "[world]\nsize = [20, 20]\nwalls = [[0, 1, 0, 2]]\n"
    analysis = analyze("ada at 1 2\nroom 6 4\nada bo $ forward\n", read_robots(toml))
    assert starts(analysis) == {"ada": [1, 2, 0], "bo": [7, 0, 0]}
    world = score_of(analysis).world
    assert (world.size, len(world.walls)) == ((6, 4), 1)


def test_robots_without_a_place_keep_their_default_starts() -> None:
    for toml in ("", "[formation]\nshape = 'circle'\n", "[world]\nsize = [6, 6]\n"):
        robots = read_robots(toml)
        free = starts(analyze("a b c d $ forward\n", robots))
        assert starts(analyze("c at 9 9 facing 90\na b c d $ forward\n", robots)) == {**free, "c": [9, 9, 90]}


def test_a_robot_that_only_stands_is_in_the_score() -> None:
    analysis = analyze("ada at 1 2\nbo $ forward\n---\nbo $ left\n")
    score = score_of(analysis)
    assert {name: part.stands for name, part in score.parts.items()} == {"bo": False, "ada": True}
    assert list(score.moving().parts) == ["bo"]
    assert len(score.parts["ada"].scenes) == 2
    assert list(analysis.robots) == ["bo"]


def test_scenes_have_names() -> None:
    for program, names in {
        "r $ left\n--- two\nr $ left\n---\nr $ up": ["", "two", ""],
        "--- one\nr $ left\n--- two\nr $ left": ["one", "two"],
        "--- zero\n--- one\nr $ left": ["", "one"],
    }.items():
        analysis = analyze(program)
        assert list(analysis.scene_names) == names
        assert score_of(analysis).scene_names == tuple(names)


def test_the_last_name_above_all_lines_that_play_names_the_first_scene() -> None:
    check(
        """
        --- zero
        ^^^^^^^^ no-effect: no robot plays above this line: remove it
        --- one
        r $ left
        """,
        hints=True,
    )


def test_lines_of_the_opening_may_stand_anywhere() -> None:
    lines = ["room 6 4", "bar 3", "ada at 1 2", "ada is quadrotor"]
    for at in range(4):
        mixed = ["ada $ forward", "---", "ada $ left"]
        mixed[at:at] = lines
        found = compiled(analyze("\n".join(mixed)))
        assert (found["bar"], found["room"], found["robots"]["ada"]["start"]) == (3, (6, 4), [1, 2, 0])


def test_lines_of_the_opening_are_formatted() -> None:
    before = (
        "room   6  4 # wide\nada  at  -1   .5   facing  -90\nada is   nao-v6\nbo cy at circle 3 / 2 around 1-2\n---x\n"
    )
    after = "room 6 4  # wide\nada at -1 .5 facing -90\nada is nao-v6\nbo cy at circle 3/2 around 1 -2\n--- x\n"
    assert format_text(before) == format_text(after) == after


def test_a_thousand_robots_on_a_circle() -> None:
    names = " ".join(f"r{number}" for number in range(1_000))
    analysis = analyze(f"{names} at circle 100\nroom 1 1\nr1 $ forward\n")
    assert analysis.ok
    assert len(score_of(analysis).parts) == 1_000
