"""Definition and references: all names of the symbol are marked, `{so}` at its definition and `<so>` at its uses."""

from __future__ import annotations

from textwrap import dedent

from improv_core.ide.references import definition, references, sections, symbol_at
from improv_core.robots.config import read_robots
from tests.ide.cursor import at_cursor


def check(program: str, marked: str) -> None:
    """Check that the symbol at the cursor stands in exactly these places."""
    analysis, offset = at_cursor(program)
    symbol = symbol_at(analysis, offset)
    text = analysis.text
    for reference in reversed(references(analysis, symbol) if symbol else []):
        start, end = reference.span
        left, right = "{}" if reference.defines else "<>"
        text = f"{text[:start]}{left}{text[start:end]}{right}{text[end:]}"
    assert text == dedent(marked).strip("\n")


def check_definition(program: str, expected: str | None) -> None:
    """Check that the definition is between `{` and `}` in the second program; None if there is none."""
    analysis, offset = at_cursor(program)
    symbol = symbol_at(analysis, offset)
    span = definition(analysis, symbol) if symbol else None
    text = analysis.text
    found = span and f"{text[: span.start]}{{{text[span.start : span.end]}}}{text[span.end :]}"
    assert found == expected


def test_a_name_has_its_definition_and_its_uses() -> None:
    marked = "{x} = left # x\nr $ <x> [<x> up]\ns $ right\nx2 = <x>"
    check("|>x = left # x\nr $ x [x up]\ns $ right\nx2 = x", marked)
    check("x = left # x\nr $ x [x| up]\ns $ right\nx2 = x".replace("|", "|>"), marked)


def test_a_name_that_is_defined_again_is_another_symbol() -> None:
    check("x = left\nx = |>x x\nr $ x", "{x} = left\nx = <x> <x>\nr $ x")
    check("x = left\nx = x x\nr $ |>x", "x = left\n{x} = x x\nr $ <x>")
    check("x = left\n|>x = x x\nr $ x", "x = left\n{x} = x x\nr $ <x>")


def test_a_parameter_stays_in_its_phrase() -> None:
    marked = "m = up\nf n ({m}) = repeat n <m> fast n/2 [<m> m2]\nr $ f 2 m"
    check(marked.replace("{m}", "|>m").replace("<m>", "m"), marked)
    check(marked.replace("{m}", "m").replace("[<m>", "[|>m").replace("<m>", "m"), marked)
    marked = "f {n} (m) = repeat <n> m fast <n>/2 up\nr $ f 2 n"
    check(marked.replace("{n}", "n").replace("t <n>", "t |>n").replace("<n>", "n"), marked)
    check_definition("m = up\nf (m) = |>m", "m = up\nf ({m}) = m")


def test_names_belong_together_across_lines_and_errors() -> None:
    check("r $ |>x\nx = x\nr $ x", "r $ <x>\nx = <x>\nr $ x")
    check("r $ |>nobody nobody", "r $ <nobody> <nobody>")
    check("x = (left\nr $ ) |>x ||\nx", "{x} = (left\nr $ ) <x> ||\n<x>")
    check("x y = left\nr $ |>x y", "{x} y = left\nr $ <x> y")


def test_a_robot_and_all_it_plays() -> None:
    check("r s $ left\nr = up\ns |>r $ r", "<r> s $ left\nr = up\ns <r> $ r")
    check("my-ro|>bot $ left\nmy-robot $ up", "<my-robot> $ left\n<my-robot> $ up")


def test_words_numbers_signs_and_comments_are_no_symbols() -> None:
    for program in ("r $ le|>ft", "r $ repeat |>2 left", "r |>  $ left", "left |>= up", "x = up # |>x", "\n|>\n"):
        check(program, program.replace("|>", "").strip("\n"))


def test_definition_is_the_one_above() -> None:
    check_definition("x = left\nx = up\nr $ |>x", "x = left\n{x} = up\nr $ x")
    check_definition("x = left\nx = |>x\nr $ x", "{x} = left\nx = x\nr $ x")
    check_definition("r $ |>x\nx = up", "r $ x\n{x} = up")
    check_definition("r $ |>x", None)
    check_definition("r $ left\n|>r $ up", "{r} $ left\nr $ up")
    check_definition("r $ |>left", None)


def test_a_robot_has_its_sections_in_improv_toml() -> None:
    text = '[robots.a]\nprofile = "x"\n[robots."a".start]\nx = 1\n[robots.b]\n'
    found = sections(read_robots(text), "a")
    assert [text[span.start : span.end] for span in found] == ["a", '"a"']
    assert [span.start for span in found] == [8, 33]
    assert sections(read_robots("robots.a.topic = 'x'\nrobots.a.message = 'Twist'\n"), "a") == [(7, 8), (28, 29)]
    assert sections(read_robots("[robots.a"), "a") == [(8, 9)]  # also if the rest is still to be typed
