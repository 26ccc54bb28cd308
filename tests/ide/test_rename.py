"""Rename: the program before and after, or the line that gives the reason for a refusal; the meaning stays the same."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.diagnostics import applied
from improv_core.ide.references import symbol_at
from improv_core.ide.rename import RefusalError, renamable, rename, rename_robot, rename_section
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from improv_core.syntax import nodes
from tests.ide.cursor import at_cursor


def check(program: str, new: str, after: str) -> None:
    assert renamed(*at_cursor(program), new) == after


def check_refused(program: str, new: str, line: str) -> None:
    with pytest.raises(RefusalError) as refused:
        renamed(*at_cursor(program), new)
    assert str(refused.value) == line


def renamed(analysis: Analysis, offset: int, new: str) -> str:
    return applied(analysis.text, rename(analysis, renamable(analysis, offset), new))


def test_a_name_and_its_uses_are_renamed() -> None:
    check("# x\n|>x = left\nr $ x [x up] # x", "turn", "# x\nturn = left\nr $ turn [turn up] # x")
    check("x = left\nr$(x|>)", "ü_2", "ü_2 = left\nr$(ü_2)")
    check("x = left\nr $ |>x", "x", "x = left\nr $ x")
    check("|>x = left\nr $ x\ny = up\nr $ y", "y", "y = left\nr $ y\ny = up\nr $ y")
    check("y = up\nr $ y\n|>x = y left\nr $ x", "y", "y = up\nr $ y\ny = y left\nr $ y")
    check("x = left\ny = |>x\nr $ y", "y", "y = left\ny = y\nr $ y")


def test_renames_that_change_the_meaning_are_refused() -> None:
    check_refused("|>x = left\ny = up\nr $ x y", "y", "`y` is already defined on line 2: choose another name")
    check_refused(
        "y = up\n|>x = left\nr $ x\nr $ y", "y", "`y` on line 4 would then mean this one: choose another name"
    )
    check_refused("|>x = left\nr $ y", "y", "`y` on line 2 would then mean this one: choose another name")


def test_a_robot_that_keeps_its_name_changes_nothing() -> None:
    assert rename_robot(analyze("r $ up"), "r", "r") == []


def test_a_parameter_is_renamed_in_its_definition_only() -> None:
    check("f n (m) = repeat |>n m x m\nr $ f 2 up", "k", "f k (m) = repeat k m x m\nr $ f 2 up")
    check("f n (|>m) = scale 4/n m", "x", "f n (x) = scale 4/n x")
    check("f n n2 = fast n*n2|>/n up", "m", "f n m = fast n*m/n up")
    check("m = up\nf (|>m) = m m\nr $ m", "x", "m = up\nf (x) = x x\nr $ m")
    check_refused("f n (|>m) = m", "n", "`n` is already a parameter of this phrase: choose another name")
    check_refused("f n (|>m) = m", "up", "`up` is a reserved word: choose another name")
    line = "this phrase uses `x`, which would then mean the parameter: choose another name"
    check_refused("x = up\nf (|>m) = m x", "x", line)
    check_refused("|>x = up\nf (m) = m x", "m", "`m` is a parameter on line 2: choose another name")


def test_names_must_be_legal() -> None:
    check_refused("|>x = left", "up", "`up` is a reserved word: choose another name")
    check_refused(
        "|>x = left", "2x", "`2x` is not a valid name: use letters, digits, and `_`, not starting with a digit"
    )
    check_refused(
        "|>r $ left",
        "ü",
        "`ü` is not a valid robot name: use a to z, digits, and `_`, starting with a letter",
    )
    check_refused("|>r $ left", "beat", "`beat` is a reserved word: choose another name")


def test_only_names_and_robots() -> None:
    line = "only names, parameters, robots, and scenes can be renamed: put the cursor on one"
    for program in ("r $ le|>ft", "r $ repeat |>3 left", "# |>x", "|>left = up", "|>"):
        check_refused(program, "x", line)
    check_refused("r $ |>x", "y", "`x` is not defined above this line: define it first")


def test_a_robot_is_renamed_in_all_lines() -> None:
    check("r s $ left\nr = up\ns |>r $ r", "anna", "anna s $ left\nr = up\ns anna $ r")
    check("my-ro|>bot $ left", "my_robot", "my_robot $ left")
    check_refused("s $ up\n|>r $ left", "s", "`s` is already a robot, on line 1: choose another name")


def test_its_sections_in_improv_toml() -> None:
    text = '[robots.r]\nprofile = "turtlesim"\n[robots.r.start]\nx = 1\n[robots.s]\n'
    assert applied(text, rename_section(read_robots(text), "r", "anna")) == text.replace("robots.r", "robots.anna")
    assert rename_section(read_robots(text), "t", "anna") == []
    with pytest.raises(RefusalError, match=r"`s` is already a robot, in improv\.toml"):
        rename_section(read_robots(text), "r", "s")
    with pytest.raises(RefusalError, match=r"fix it first"):
        rename_section(read_robots("[robots.r"), "r", "s")


NAMES = st.sampled_from("abc")
TERMS = st.one_of(
    NAMES,
    st.sampled_from(
        ["left", "forward", "[a b]", "repeat 2 c", "reverse (b c)", "a || up", "until a b", "if near a else b"]
    ),
)
MOVEMENTS = st.lists(TERMS, min_size=1, max_size=3).map(" ".join)
STATEMENTS = st.one_of(
    st.builds("{} = {}".format, NAMES, MOVEMENTS),
    st.builds("{} s ({}) = {} fast s left".format, NAMES, NAMES, MOVEMENTS),
    st.builds("{} $ {}".format, st.sampled_from(["r", "r s"]), MOVEMENTS),
)
PROGRAMS = st.lists(STATEMENTS, min_size=1, max_size=8).map("\n".join)


def meaning(analysis: Analysis, robots: dict[str, str]) -> tuple[Any, list[int | None]]:
    """Return the compiled program with other names for its robots, and the definition of each name used in it."""
    found = dict(compiled(analysis))
    found["robots"] = {robots.get(name, name): part for name, part in found["robots"].items()}
    uses = [
        (index, None if name.text in (each.name for each in statement.parameters) else name.text)
        for index, statement in enumerate(analysis.statements)
        if statement.body
        for name in nodes.names(statement.body)
    ]
    return found, [analysis.bindings.definer(name, index) if name else None for index, name in uses]


@given(PROGRAMS, st.data())
def test_a_renamed_program_means_the_same(program: str, data: st.DataObject) -> None:
    analysis = analyze(program)
    symbols = [symbol_at(analysis, offset) for offset in range(len(program))]
    symbol = data.draw(
        st.sampled_from([each for each in symbols if each and (each.kind == "robot" or each.definer is not None)])
    )
    new = data.draw(st.sampled_from("abcdrst"))
    try:
        after = analyze(applied(program, rename(analysis, symbol, new)))
    except RefusalError:
        parameters = {each.name for statement in analysis.statements for each in statement.parameters}
        taken = {*analysis.bindings.defined, *analysis.bindings.used, *parameters}
        assert new in (analysis.robots if symbol.kind == "robot" else taken)
        return
    robots = {symbol.text: new} if symbol.kind == "robot" else {}
    assert meaning(after, {}) == meaning(analysis, robots)
