"""The beat that each line has reached, at the end of the line, even after an edit."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from textwrap import dedent

from improv_core.ide.inlay_hint import playing_hints
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.score.replay import Replay


def shown(played: Analysis, beat: float, now: Analysis | None = None, replay: Replay | None = None) -> str:
    """Return the program with the hints in it: `r $ left up <beat 1/2>`."""
    now = now or played
    text = now.text
    for hint in reversed(playing_hints(replay or Replay(score_of(played)), now, beat)):
        text = f"{text[: hint.offset]} <{hint.text}>{text[hint.offset :]}"
    return text


def check(beat: float, expected: str) -> None:
    """Check the hints at a beat of the program without them."""
    expected = dedent(expected).strip("\n")
    program = "\n".join(line.partition(" <")[0] for line in expected.split("\n"))
    assert shown(analyze(program), beat) == expected


def test_each_robot_is_at_its_own_line() -> None:
    check(0, "r s $ left up <beat 1/2>\nr $ slow 3/2 left\ns $ up")
    check(1.9, "r s $ left up <beat 2/2>\nr $ slow 3/2 left\ns $ up")
    check(2, "r s $ left up\nr $ slow 3/2 left <beat 1/2>\ns $ up <beat 1/1>")
    check(3.2, "r s $ left up\nr $ slow 3/2 left <beat 2/2>\ns $ up")
    check(100, "x = left\nr $ repeat x <beat 101/∞>")
    check(1, "r s $ canon 2 left <beat 2/3>")


def test_lines_of_later_scenes_count_from_their_scene() -> None:
    check(1.5, "r $ left\ns $ repeat 2 up <beat 2/2>\n---\nr $ up up")
    check(2.5, "r $ left\ns $ repeat 2 up\n---\nr $ up up <beat 1/2>")


def test_text_that_moved_and_text_that_was_edited() -> None:
    played = analyze("r $ left\ns $ up up\n")
    later = played.edited(0, 0, "# first\n")
    assert shown(played, 0, later) == "# first\nr $ left <beat 1/1>\ns $ up up <beat 1/2>\n"
    later = played.edited(4, 8, "right")
    assert shown(played, 0, later) == "r $ right\ns $ up up <beat 1/2>\n"


def test_open_movements_have_no_last_beat() -> None:
    played = analyze("r $ left until near (repeat up)\nr $ left right\n")
    replay = Replay(score_of(played))
    replay.sense("r", "near", False, 0)
    assert shown(played, 2, replay=replay) == "r $ left until near (repeat up) <beat 3>\nr $ left right\n"
    replay.sense("r", "near", True, Fraction(5, 2))
    assert shown(played, 3.5, replay=replay) == "r $ left until near (repeat up)\nr $ left right <beat 1/2>\n"


def test_a_robot_that_entered_late_counts_from_there() -> None:
    played = analyze("r $ left up\ns $ up\n")
    score = score_of(played)
    late = Replay(replace(score, parts={**score.parts, "r": replace(score.parts["r"], begins=7)}))
    assert shown(played, 5, replay=late) == "r $ left up\ns $ up\n"
    assert shown(played, 8, replay=late) == "r $ left up <beat 2/2>\ns $ up\n"
