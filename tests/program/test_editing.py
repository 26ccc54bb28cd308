"""An edited program has the same analysis as a new one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.movement import ENDLESS
from improv_core.score.score_json import to_json

WORDS = (
    "x y z r forward left repeat 2 1.5 reverse reflect YZ fast = $ ( ) [ ] || # n (m) accumulate shuffle ease * / 😀"
)
PIECES = [*WORDS.split(), "beat 60", "seed 2", "fit 2", "ramp 1 2", "if near", "until not cue", " ", "  ", "\t", "x = "]
PIECES += ["\n", "\n", "\n", "\r\n", "\r", "\u2028", "\f", "\ufeff", "\nr $ ", "\ny = ", "\n---\n", "\n|| ", "\nelse "]
PIECES += ["\nx = x left\n", "\nr $ x || y\n", "\nbeat 30\n", "\nx n (m) = repeat n m\n", "\ny (m) = m x 2 m\n"]
PIECES += ["\nr $ x 3 left\n", "\nr q $ canon 1 y left\n", "\nr $ choose (left right)\n", "\nq $ chance 1/2 left\n"]
PIECES += ["\nr at 1 2\n", "\nr q at circle 1\n", "\nr is husky\n", "\nq is nobody\n", "\nroom 6 4\n", "\nbar 3\n"]
PIECES += ["\nr is puppet\n", "\nhead = head left\n", "\nr $ head x\n", "\nx = arms y\n", "\nto (m) = m left\n"]
PIECES += ["head ", "arms ", "to high", "to ", "left_arm ", "\nr $ head to start\n", "\nr $ left_arm (to high || up)\n"]
PIECES += ["\n--- x\n", "at", "is", "room", "bar", "\nr at "]
texts = st.lists(st.sampled_from(PIECES), max_size=40).map("".join)
edits = st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1), st.lists(st.sampled_from(PIECES), max_size=4)), max_size=6)


def after(statements: int) -> Callable[[], bool]:
    """Return a function that returns true from this many calls on."""
    left = iter(range(statements - 1))
    return lambda: next(left, None) is None


def seen(analysis: Analysis) -> dict[str, Any]:
    """Return everything that callers read from an analysis, except the IDs of statements."""
    score = to_json(score_of(analysis))
    for row in score["movements"]:
        if row[0] == "use":
            row[-1] = analysis.statement_ids.index(row[-1])
    score["offsets"] = [offset for _, offset in score["offsets"]]
    return {
        "text": analysis.text,
        "lines": analysis.lines.starts,
        "offsets": analysis.offsets,
        "statements": [statement.text for statement in analysis.statements],
        "diagnostics": analysis.diagnostics,
        "tempo": analysis.tempo,
        "opening": analysis.opening,
        "score": score,
        "defined": analysis.bindings.defined,
        "used": analysis.bindings.used,
    }


def edited(text: str, several: list[tuple[float, float, list[str]]]) -> Iterator[tuple[int, int, str, str]]:
    """Yield each edit: its start, its end, its text, and the text of the program after it."""
    for one, other, pieces in several:
        start, end = sorted((round(one * len(text)), round(other * len(text))))
        end = min(end, start + 7)  # most edits of people are small
        put = "".join(pieces)
        text = text[:start] + put + text[end:]
        yield start, end, put, text


@given(texts, edits)
def test_an_edited_analysis_equals_a_new_one(text: str, several: list[tuple[float, float, list[str]]]) -> None:
    analysis = analyze(text)
    for start, end, put, after_it in edited(text, several):
        analysis = analysis.edited(start, end, put)
        assert seen(analysis) == seen(analyze(after_it))


@given(texts, edits, st.integers(0, 2))
def test_an_analysis_settled_in_slices_equals_a_new_one(
    text: str, several: list[tuple[float, float, list[str]]], most: int
) -> None:
    analysis = analyze(text)
    for start, end, put, after_it in edited(text, several):
        analysis = analysis.touched(start, end, put).settled(after(most))
        far = len(after_it) // 2
        assert all(analysis.offsets[index] > far for index in analysis.settled(until=far).waiting)
    assert seen(analysis.settled()) == seen(analyze(analysis.text))


@pytest.mark.parametrize(
    ("text", "before", "put", "kept"),
    [
        ("x = forward\ny = x left\nz = left\nr $ y\nr $ z\n", "forward", "backward", [2, 4]),
        # A key in the body of a phrase costs its uses, and one in an argument costs its line.
        ("p n = repeat n left\nx (m) = p 3 m\nr $ p 5\nr $ left\nr $ x right\n", "left", "right", [3]),
        ("p n (m) = repeat n m\nr $ p 5 left\nr $ p 5 up\n", "left", "right", [0, 2]),
    ],
)
def test_only_statements_that_depend_on_an_edit_are_read_again(
    text: str, before: str, put: str, kept: list[int]
) -> None:
    analysis, start = analyze(text), text.index(before)
    edited = analysis.edited(start, start + len(before), put)
    pairs = enumerate(zip(analysis.meanings, edited.meanings, strict=True))
    assert [place for place, (one, other) in pairs if one is other] == kept
    longer = edited.edited(0, 0, "a = left\n")
    assert longer.meanings[1:] == edited.meanings


def test_waiting_statements_are_read_in_the_order_of_the_text() -> None:
    analysis = analyze("x = forward\n" + "r $ x\n" * 5)
    edited = analysis.touched(4, 11, "repeat left").settled(after(3))
    lengths = [[each.movement.duration for each in now.meanings[1:]] for now in (edited, edited.settled(after(2)))]
    assert lengths == [[ENDLESS, ENDLESS, 1, 1, 1], [ENDLESS, ENDLESS, ENDLESS, ENDLESS, 1]]
    assert edited.settled(until=edited.offsets[3]).waiting == [4, 5]
    assert edited.settled().waiting == []


def test_a_line_still_waits_for_its_check_after_a_line_is_added() -> None:
    """The same happens if improv.toml and the program change at the same time."""
    robots = read_robots("[robots.anna]\n", Path("improv.toml"))
    waiting = analyze("anna $ left\nbert $ right\n").with_robots(robots)
    edited = waiting.touched(0, 0, "anna $ forward\n").settled()
    assert [each.code for each in edited.diagnostics] == ["unknown-robot"]
    assert edited.diagnostics == analyze(edited.text, robots).diagnostics
