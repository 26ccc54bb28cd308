"""Hover: what is marked, and what is said about it."""

from __future__ import annotations

from improv_core.analysis import analyze
from improv_core.ide.hover import hover, summary
from tests.ide.cursor import at_cursor


def check(program: str, marked: str, *said: str) -> None:
    """Hovering at the cursor marks a text and says each of these."""
    analysis, offset = at_cursor(program)
    found = hover(analysis, offset)
    assert found
    assert analysis.text[found.span.start : found.span.end] == marked
    for part in said:
        assert part in found.text


def check_nothing(program: str) -> None:
    assert hover(*at_cursor(program)) is None


def test_words_say_what_they_do_how_long_and_how_far() -> None:
    check("r $ for|>ward", "forward", "**forward**: One step forward.", "1 beat, 1.0 s at beat 60 · 2.0 m, no turn")
    check("beat 30\nr $ |>halfright", "halfright", "1 beat, 2.0 s at beat 30 · 0.0 m, turns 45° right")
    check("b|>eat 92.5", "beat", "**beat 92.5**")


def test_transformers_speak_of_the_term_they_apply_to() -> None:
    check("r $ re|>peat 4 (forward left)", "repeat 4 (forward left)", "**repeat 4**", "8 beats", "turns 360° left")
    check("r $ fast |>3/2 left right", "fast 3/2 left", "2/3 beats, 0.67 s")
    check("r $ reflect Y|>Z left", "reflect YZ left", "Left and right change places", "turns 90° right")
    check("r $ repeat le|>ft", "left", "1 beat")
    check("r $ rep|>eat left", "repeat left", "∞, endless at beat 60 · goes on for ever")


def test_brackets_say_what_they_make_of_their_items() -> None:
    check("r $ [|>forward left]", "forward", "1 beat")
    check("r $ |>[forward left] right", "[forward left]", "squeezed: 2 items, 2 times as fast", "1 beat, 1.0 s")
    check(
        "r $ [forward left || left|>]",
        "[forward left || left]",
        "2 items, 2 times as fast and 1 item, at its own speed",
    )
    check("r $ |>(forward left)", "(forward left)", "2 beats")


def test_names_are_shown_as_they_were_defined_above() -> None:
    program = "x = forward\nx = x left\nr $ |>x"
    check(program, "x", "(name, line 2)", "x = x left", "2 beats")
    check("x = forward\nx = |>x left", "x", "(name, line 1)", "1 beat")
    check("|>x = forward", "x", "**x** (name)", "1 beat")


def test_robots_and_signs_speak_of_all_that_is_played() -> None:
    check("|>r $ forward\nr $ left", "r", "robot, profile turtlesim", "2 beats")
    check("r1 r2 |>$ forward", "$", "r1, r2 plays what follows", "1 beat")
    check("x |>= forward", "=", "`x` stands for what follows")
    check("r $ forward |>|| left", "forward || left", "play at once", "2.0 m, turns 90° left")


def test_broken_statements_still_tell_what_they_hold() -> None:
    check("r $ (for|>ward left\nx = ", "forward", "1 beat")
    check("r $ re|>peat", "repeat", "**repeat**")


def test_nothing_to_say() -> None:
    check_nothing("r $ left # |> comment")
    check_nothing("r $ |>nobody")
    check_nothing("r $ left\n\n|>")


def test_huge_durations_are_told_at_once() -> None:
    huge = "repeat 1000000000 (repeat 1000000000 (forward left))"
    check(f"r $ |>{huge}", huge, "2000000000000000000 beats", "2,000,000,000,000,000,000.0 m")


def test_summary() -> None:
    program = "beat 30\nturtle1 $ repeat 8 forward\nturtle2 $ slow 4 left\n"
    assert summary(analyze(program)) == "turtle1 8 beats · turtle2 4 beats, 16.0 s at beat 30"
    assert summary(analyze("r1 $ left\nr2 $ repeat left")) == "r1 1 beat · r2 ∞, endless at beat 60"
    assert summary(analyze("# nothing")) == "no robot plays"
