"""Gestures on the floor: before, the cursor `|>` in a movement; after, the program."""

from __future__ import annotations

from pathlib import Path

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.bending import bent, handle_at, lengthened
from improv_core.ide.insertion import gap_at
from improv_core.program.analysis import analyze
from improv_core.program.files import robots_near
from tests.ide.cursor import at_cursor

PUPPETS = robots_near(Path(__file__).parents[2] / "examples")


def check(before: str, to: tuple[float, float], after: str, *, freely: bool = False) -> None:
    """Check what dragging the handle at the cursor to a place makes of a program, and that the handle is there then."""
    analysis, offset = at_cursor(before)
    text = applied(analysis.text, bent(analysis, offset, to, freely))
    assert text == after
    moved = handle_at(analysis.edited(0, len(analysis.text), text), offset)
    assert moved


@pytest.mark.parametrize(
    ("before", "to", "after"),
    [
        ("ada $ for|>ward", (1.23, 0.4), "ada $ forward 1.2m"),
        ("ada $ forward 1.|>5m", (0.52, 0), "ada $ forward 50cm"),
        ("ada $ forward 1.|>5m", (-0.02, 0), "ada $ forward 10cm"),
        ("ada $ forward 15|>0cm", (1.62, 0), "ada $ forward 1.6m"),
        ("ada $ forward 15|>0cm", (0.52, 0), "ada $ forward 50cm"),
        ("ada $ |>forward 1.5m", (2, 0), "ada $ forward 2m"),
        ("ada $ |>forward", (-0.8, 0), "ada $ backward 80cm"),
        ("ada $ forward le|>ft", (3, -1.1), "ada $ forward halfright"),
        ("ada $ left 90|>deg", (-1, 0.01), "ada $ left 180deg"),
        ("ada $ left 9|>0deg radius 1m", (0, 2), "ada $ left 180deg radius 1m"),
        ("ada $ strafe|>left", (0.3, 1.5), "ada $ strafeleft 1.5m"),
        ("ada $ (for|>ward || left)", (2.55, 2.55), "ada $ (forward 4m || left)"),
        ("ada $ reflect sagittal (forward le|>ft)", (2, 3), "ada $ reflect sagittal (forward right)"),
        ("ada $ slow 3 (ease |>forward)", (1, 0), "ada $ slow 3 (ease forward 1m)"),
        ("ada $ repeat 4 (forward left|>)", (2, -1), "ada $ repeat 4 (forward right)"),
        ("ada $ repeat 4 (forward left 90deg|>)", (2, -1), "ada $ repeat 4 (forward right 90deg)"),
        ("side = for|>ward\nada $ repeat 4 (side left)", (1, 0), "side = forward 1m\nada $ repeat 4 (side left)"),
    ],
)
def test_the_word_moves_as_far_as_its_handle(before: str, to: tuple[float, float], after: str) -> None:
    check(f"ada at 0 0\n{before}", to, f"ada at 0 0\n{after}")


def test_a_free_hand_is_exact_to_a_centimeter_and_a_degree() -> None:
    check("ada at 0 0\nada $ for|>ward", (1.234, 0), "ada at 0 0\nada $ forward 1.23m", freely=True)
    check("ada at 0 0\nada $ le|>ft", (1, 0.7), "ada at 0 0\nada $ left 35deg", freely=True)


@pytest.mark.parametrize(
    ("before", "steps", "after"),
    [
        ("ada $ |>forward", 1, "ada $ forward 2.1m"),
        ("ada $ |>forward 1.25m", 1, "ada $ forward 1.3m"),
        ("ada $ |>forward 1.25m", -1, "ada $ forward 1.2m"),
        ("ada $ |>backward 30cm", 1, "ada $ backward 40cm"),
        ("ada $ |>forward 10cm", -1, "ada $ backward 10cm"),
        ("ada $ |>left", 3, "ada $ left 135deg"),
        ("ada $ |>left", -3, "ada $ halfleft"),
    ],
)
def test_keys_make_a_word_longer_or_shorter(before: str, steps: int, after: str) -> None:
    analysis, offset = at_cursor(before)
    assert applied(analysis.text, lengthened(analysis, offset, steps, freely=False)) == after


def test_the_handle_shows_where_the_same_word_ends_elsewhere() -> None:
    analysis, offset = at_cursor("ada at 0 0\nbo at 0 5\nside = for|>ward\nada bo $ repeat 2 (side left)")
    handle = handle_at(analysis, offset)
    assert handle
    assert (handle.robot, handle.text, handle.place) == ("ada", "forward", (2, 0, 2, 0))
    assert [(round(x, 6), round(y, 6)) for x, y, *_ in handle.others] == [(2, 2), (2, 5), (2, 7)]


def test_a_turn_has_its_handle_ahead_of_the_robot() -> None:
    analysis, offset = at_cursor("ada at 0 0\nada $ le|>ft")
    handle = handle_at(analysis, offset)
    assert handle
    assert handle.place == pytest.approx((0, 1, 0, 0))


@pytest.mark.parametrize(
    "line",
    ["ada $ right_arm (to high [ri|>ght left])", "ada $ (left || head ri|>ght)", "nod = ri|>ght\nada $ head nod"],
)
def test_a_word_for_a_body_part_has_no_handle(line: str) -> None:
    before = f"ada is puppet\n{line}"
    offset = before.index("|>")
    assert handle_at(analyze(before.replace("|>", ""), PUPPETS), offset) is None


@pytest.mark.parametrize(
    "program",
    [
        "ada $ re|>st",
        "ada $ u|>p",
        "ada $ rep|>eat 4 forward",
        "f n = forward n*|>1m\nada $ f 2",
        "ada $ (for|>ward || backward)",
        "ada $ (forward || le|>ft || right)",
        "side = for|>ward\nada $ left",
        "ada $ for|>ward lft",
        "# for|>ward",
    ],
)
def test_a_word_that_moves_nobody_or_that_is_computed_has_no_handle(program: str) -> None:
    analysis, offset = at_cursor(program)
    assert handle_at(analysis, offset) is None
    assert bent(analysis, offset, (1, 1), freely=False) == ()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ for|>ward 2.2m left", "ada $ forward 2.2m rest left"),
        ("ada $ |>forward left", "ada $ forward rest left"),
        ("ada $ forward left 9|>0deg radius 1m", "ada $ forward left 90deg radius 1m rest"),
        ("ada $ repeat 2 (forward left|>)", "ada $ repeat 2 (forward left rest)"),
        ("ada $ forward |> left", "ada $ forward rest left"),
    ],
)
def test_words_stand_behind_the_word_at_the_cursor_and_its_measures(before: str, after: str) -> None:
    analysis, offset = at_cursor(before)
    gap = gap_at(analysis, offset)
    assert gap
    assert " ".join(applied(analysis.text, [gap.filled("rest")]).split()) == after
