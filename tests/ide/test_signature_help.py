"""Signature help: how the transformer at the cursor is written, with what is being written there in brackets."""

from __future__ import annotations

from improv_core.ide.signature_help import signature
from tests.ide.cursor import at_cursor


def check(program: str, shown: str) -> None:
    found = signature(*at_cursor(program))
    assert found
    start, end = found.parameters[found.active]
    assert f"{found.label[:start]}<{found.label[start:end]}>{found.label[end:]}" == shown
    assert found.about


def check_nothing(program: str) -> None:
    assert signature(*at_cursor(program)) is None


def test_the_number_or_the_plane_comes_first() -> None:
    check("r $ repeat |>", "repeat <n> movement")
    check("r $ repeat 4|>", "repeat <n> movement")
    check("r $ reflect |>", "reflect <PLANE> movement")
    check("r $ reflect Y|>Z left", "reflect <PLANE> movement")
    check("r $ fast |> left", "fast <k> movement")


def test_then_the_movement() -> None:
    check("r $ repeat 4 |>", "repeat n <movement>")
    check("r $ repeat fo|>", "repeat n <movement>")
    check("r $ repeat (|>", "repeat n <movement>")
    check("r $ slow 3/2 le|>ft", "slow k <movement>")
    check("r $ reflect YZ (left |> )", "reflect PLANE <movement>")
    check("r $ reverse |>", "reverse <movement>")
    check("x = repeat 4 (\n  left\n  |>\n)", "repeat n <movement>")


def test_the_innermost() -> None:
    check("r $ repeat 4 (reverse |>", "reverse <movement>")
    check("r $ repeat 4 (reverse left |>", "repeat n <movement>")
    check("r $ repeat 2 fast |>", "fast <k> movement")
    check("r $ repeat 2 (left) slow 2 [up |>", "slow k <movement>")


def test_nothing_outside() -> None:
    for program in ("r $ |>", "r $ repeat 4 left |>", "repeat |>", "r $ repeat 4 (left) |>", "r $ repeat # |>", "|>"):
        check_nothing(program)
    check_nothing("r $ repeat 4 left || |>")
    check_nothing("r $ repeat|>")
