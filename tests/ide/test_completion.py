"""Completion: what is offered where the cursor stands."""

from __future__ import annotations

from improv_core.ide.completion import complete
from improv_core.syntax.vocabulary import Kind, of_kind
from tests.ide.cursor import at_cursor

MOVING = of_kind(Kind.PRIMITIVE, Kind.MIRROR, Kind.REPEAT, Kind.REFLECT, Kind.FACTOR)
PLANES = of_kind(Kind.PLANE)


def check(program: str, *labels: str) -> None:
    """At the cursor exactly these are offered, and they replace the word that has been begun."""
    analysis, offset = at_cursor(program)
    items = complete(analysis, offset)
    assert [item.label for item in items] == list(labels)
    for item in items:
        begun = analysis.text[item.span.start : item.span.end]
        assert item.span.end == offset
        assert begun == "" or begun.isidentifier()


def test_a_line_begins_with_the_tempo_or_a_robot() -> None:
    check("|>", "beat")
    check("r1 $ left\n|>\n", "beat", "r1")
    check("r1 $ left\nr|>", "beat", "r1")
    check("r1 r2 $ left\nr1 |>", "r1", "r2")


def test_a_movement_is_a_word_or_a_name_defined_above() -> None:
    check("x = left\nr $ fo|>\nz = right", *MOVING, "x")
    check("x = left\nr $ x || |>", *MOVING, "x")
    check("x = left\nr $ fast 2 [|>", *MOVING, "x")
    check("x = |>", *MOVING)
    check("r $ repeat 2 re|>peat 3 left", *MOVING)


def test_an_open_bracket_goes_on_over_lines() -> None:
    check("x = (left\n  |>", *MOVING)
    check("x = (left)\n|>", "beat")


def test_a_plane_after_reflect_and_nothing_where_a_number_must_stand() -> None:
    check("r $ reflect |>", *PLANES)
    check("r $ reflect s|>", *PLANES)
    check("r $ fast |>")
    check("beat |>")
    check("r $ repeat 2|>")


def test_nothing_in_comments() -> None:
    check("# |>")
    check("r $ left # fo|>")


def test_works_in_the_middle_of_broken_text() -> None:
    check("x = left\nr $ ) fast || |> ]", *MOVING, "x")
