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


def performed(before: str) -> str:
    """Return the program after somebody has moved ada a step ahead."""
    change: PerformPart = {"type": "perform", "robot": "ada", "keys": [[0.02, 1, 0]], "end": 1.1, "parts": 1}
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
        ("ada $ (left)|> # on", "ada $ (left) forward 1m # on"),
    ],
)
def test_a_drawing_is_written_behind_the_word_at_the_cursor(before: str, after: str) -> None:
    assert drawn(before) == after


def test_a_drawing_elsewhere_becomes_a_line_of_a_robot_that_begins_there() -> None:
    assert drawn("", 1, 2, math.pi / 2) == "ada at 1 2 facing 90\nada $ forward 1m\n"
    assert drawn("# mine|>\nada $ left\n", 1, 2) == "# mine\nada at 1 2\nada $ forward 1m\n"


def test_a_drawing_that_begins_at_a_robot_leaves_its_start() -> None:
    assert drawn("ada at 3 1\nada $ left\n", 3.02, 1, math.pi / 2) == "ada at 3 1\nada $ left forward 1m\n"


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", "ada $ forward\n"),
        ("bo $ left", "bo $ left\nada $ forward\n"),
        ("ada $ left # mine\n", "ada $ forward # mine\n"),
        ("ada bo cy $ left\nbo $ up\n", "bo cy $ left\nada $ forward\nbo $ up\n"),
        ("bo ada $ left\r\n", "bo $ left\r\nada $ forward\r\n"),
        ("ada $ left\n---\nbo $ left\n", "ada $ left\n---\nbo $ left\nada $ forward\n"),
        ("ada $ left\n---\nada $ right\n", "ada $ left\n---\nada $ forward\n"),
    ],
)
def test_a_performance_becomes_the_line_of_its_robot_in_the_last_scene(before: str, after: str) -> None:
    assert performed(before) == after
