"""Drawings and performances on the page → edits of the program, at the cursor `|>` or as a robot's line."""

from __future__ import annotations

import math

import pytest

from improv_core.diagnostics import applied
from improv_core.page.program_changes import edits_of
from improv_core.program.analysis import analyze
from improv_core.protocol.editing import DrawPath, PerformPart

POINTS = [[0.1 * number, 0.05 * number, 0.0] for number in range(21)]
"""A line of a meter along x, in two beats."""


def drawn(before: str, x: float = 0.0, y: float = 0.0, turn: float = 0.0) -> str:
    """Return the program after somebody has drawn a line of a meter from a place on."""
    cos, sin = math.cos(turn), math.sin(turn)
    points = [[beat, x + cos * far, y + sin * far] for beat, far, _ in POINTS]
    change: DrawPath = {"type": "draw", "robot": "ada", "points": points, "parts": 0}
    if "|>" in before:
        change["offset"] = before.index("|>")
    text = before.replace("|>", "")
    edits = edits_of(analyze(text), change)
    assert edits is not None
    return applied(text, edits)


def performed(before: str, begin: float = 0.0) -> str:
    """Return the program after somebody has moved ada a step ahead, from a beat on."""
    change: PerformPart = {"type": "perform", "robot": "ada", "keys": [[0.02, 1, 0]], "end": 1.1, "parts": 1}
    if begin:
        change["begin"] = begin
    edits = edits_of(analyze(before), change)
    assert edits is not None
    return applied(before, edits)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ left|> right", "ada $ left right forward 1m right"),
        ("ada $ |>", "ada $ forward 1m"),
        ("ada $|> left", "ada $ forward 1m left"),
        ("walk = repeat 4 (left|>)", "walk = repeat 4 (left forward 1m)"),
        ("ada $ (left)|> # on", "ada $ (left) right forward 1m # on"),
    ],
)
def test_a_drawing_is_written_behind_the_word_at_the_cursor(before: str, after: str) -> None:
    assert drawn(before) == after


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ left left|> right", "ada $ left left left forward right"),
        ("ada $ repeat 2 left|>", "ada $ repeat 2 left left forward"),
        ("turn = left left|>\nada $ turn", "turn = left left left forward\nada $ turn"),
        ("bo $ left|>", "bo $ left\nada $ right forward 1m"),  # another robot comes there
    ],
)
def test_a_drawing_begins_where_the_robot_comes_to_the_cursor(before: str, after: str) -> None:
    start = "ada at 0 2 facing 0\n"
    assert drawn(f"{start}{before}", 0, 2 if "bo" in before else 1, -math.pi / 2) == f"{start}{after}"


def test_a_drawing_elsewhere_becomes_a_line_of_a_robot_that_begins_there() -> None:
    assert drawn("", 1, 2, math.pi / 2) == "ada at 1 2 facing 90\nada $ forward 1m"
    assert drawn("# mine|>\nada $ left\n", 1, 2) == "# mine\nada at 1 2\nada $ forward 1m\n"


def test_a_drawing_that_begins_at_a_robot_leaves_its_start() -> None:
    assert drawn("ada at 3 1\nada $ left\n", 3.02, 1, math.pi / 2) == "ada at 3 1\nada $ left forward 1m\n"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", "ada $ forward"),
        ("bo $ left", "bo $ left\nada $ forward"),
        ("ada $ left # mine\n", "ada $ forward # mine\n"),
        ("ada bo cy $ left\nbo $ up\n", "bo cy $ left\nada $ forward\nbo $ up\n"),
        ("bo ada $ left\r\n", "bo $ left\r\nada $ forward\r\n"),
        ("ada $ left\n---\nbo $ left\n", "ada $ left\n---\nbo $ left\nada $ forward\n"),
        ("ada $ left\n---\nada $ right\n", "ada $ left\n---\nada $ forward\n"),
        ("ada $ left\nbo $ up\nada $ up\n", "ada $ forward\nbo $ up\n"),
        ("ada bo $ left\nbo ada $ up\nada $ up # mine\n", "bo $ left\nada $ forward\nbo $ up\n"),
    ],
)
def test_a_performance_becomes_the_line_of_its_robot_in_the_last_scene(before: str, after: str) -> None:
    assert performed(before) == after


@pytest.mark.parametrize(
    ("before", "begin", "after"),
    [
        ("ada $ repeat 4 (forward left)", 3, "ada $ (repeat 4 (forward left) || repeat 3 rest) forward"),
        ("ada $ repeat 4 (forward left)", 0.5, "ada $ (repeat 4 (forward) || fast 2 rest) forward"),
        ("a = left\nada $ [up a] a right [a a] up", 1.5, "a = left\nada $ ([up a] a || slow 3/2 rest) forward"),
        ("ada $ repeat left", 0.5, "ada $ (repeat left || fast 2 rest) forward"),
        ("ada $ repeat left", 2.5, "ada $ (repeat left || slow 5/2 rest) forward"),
        ("ada $ left right", 2, "ada $ left right forward"),
        ("ada bo $ left || up", 2, "bo $ left || up\nada $ (left || up) rest forward"),
        ("ada $ left\n---\nada $ right right", 2, "ada $ left\n---\nada $ (right || rest) forward"),
        ("ada $ left || up\nada $ repeat 4 up\n", 3, "ada $ (left || up) (repeat 4 up || repeat 2 rest) forward\n"),
        ("bo $ slow 4 left\n", 3, "bo $ slow 4 left\nada $ repeat 3 rest forward\n"),
    ],
)
def test_a_performance_in_the_middle_keeps_what_came_before(before: str, begin: float, after: str) -> None:
    found = performed(before, begin)
    assert found == after
    assert "never-performed" not in {each.code for each in analyze(found).diagnostics}


def test_a_drag_in_the_middle_begins_where_the_robot_is_then() -> None:
    points = [[1 + beat, 2.0, 4 + far] for beat, far, _ in POINTS]  # a beat later
    change: DrawPath = {"type": "draw", "robot": "ada", "points": points, "parts": 1, "begin": 3.0}
    text = "ada at 0 2\nada $ repeat (forward left)"
    edits = edits_of(analyze(text), change)
    assert edits is not None
    assert applied(text, edits).endswith("ada $ (repeat (forward left) || repeat 3 rest) rest slow 2 forward 1m")
