"""Inlay hints, drawn into the program as `⟨…⟩` where an editor shows them, or as `<…>` while it plays."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from textwrap import dedent

from improv_core.ide.inlay_hint import hints, playing_hints
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.score.replay import Replay
from improv_core.text import Span


def check(program: str, shown: str) -> None:
    """Check the whole program with its hints."""
    assert drawn(program, Span(0, len(program))) == shown


def drawn(program: str, seen: Span) -> str:
    text = program
    for hint in sorted(hints(analyze(program), seen), key=lambda hint: hint.offset, reverse=True):
        text = f"{text[: hint.offset]}⟨{hint.text}⟩{text[hint.offset :]}"
    return text


def test_each_statement_shows_its_length() -> None:
    check(
        "beat 30\nsquare = repeat 4 (forward left)  # 🐢\r\nr $ square || repeat up\ns $ slow 1/3 up",
        "beat 30\nsquare = repeat 4 (forward left)⟨8 beats⟩  # 🐢\r\n"
        "r $ square || repeat up⟨8 beats⟩\ns $ slow 1/3 up⟨1/3 beats⟩",
    )
    check("r $ repeat up", "r $ repeat up⟨∞⟩")
    check("r $ (up\n  left\n)", "r $ (up\n  left\n)⟨2 beats⟩")


def test_nested_brackets_show_their_rates() -> None:
    check("r $ [up [left right] up]", "r $ [up [⟨×6⟩left right] up]⟨1 beat⟩")
    check("r $ [up slow 2 [left right || down]]", "r $ [up slow 2 [⟨×2⟩left right || down]]⟨1.5 beats⟩")
    check("r $ [up ([left left left])]", "r $ [up ([⟨×6⟩left left left])]⟨1 beat⟩")
    check("r $ [up left] [[up]]", "r $ [up left] [[up]]⟨2 beats⟩")


def test_wrong_statements_get_no_hint() -> None:
    for program in ("r $ lft up", "r $ (up", "r $ repeat 1/2 up", "beat 60", "# 🐢", "up", "r $", "x = []x"):
        check(program, program)
    check("x = lft\ny = x up\nr $ repeat 4 y", "x = lft\ny = x up\nr $ repeat 4 y")
    check("x = up # unused\nr $ lft\ns $ ()", "x = up⟨1 beat⟩ # unused\nr $ lft\ns $ ()⟨0 beats⟩")


def test_only_what_is_in_sight() -> None:
    program = "r $ up\ns $ up\nt $ up\n"
    assert drawn(program, Span(8, 12)) == "r $ up\ns $ up⟨1 beat⟩\nt $ up\n"
    (hint,) = hints(analyze("beat 30\nr $ up left"), Span(9, 10))
    assert (hint.text, hint.about) == ("2 beats", "4.0 s at beat 30")


def test_arguments_show_their_parameters() -> None:
    phrases = "f n (m) = repeat n m\ng (m) (k) = m k\n"
    check(
        f"{phrases}r $ f 2 (up) g f 4/2 up left",
        f"{phrases}r $ f ⟨n:⟩2 ⟨m:⟩(up) g ⟨m:⟩f ⟨n:⟩4/2 ⟨m:⟩up ⟨k:⟩left⟨5 beats⟩",
    )


def shown(played: Analysis, beat: float, now: Analysis | None = None, replay: Replay | None = None) -> str:
    """Return the program with the hints in it: `r $ left up <beat 1/2>`."""
    now = now or played
    text = now.text
    for hint in reversed(playing_hints(replay or Replay(score_of(played)), now, beat)):
        text = f"{text[: hint.offset]} <{hint.text}>{text[hint.offset :]}"
    return text


def check_playing(beat: float, expected: str) -> None:
    """Check the hints at a beat of the program without them."""
    expected = dedent(expected).strip("\n")
    program = "\n".join(line.partition(" <")[0] for line in expected.split("\n"))
    assert shown(analyze(program), beat) == expected


def test_each_robot_is_at_its_own_line() -> None:
    check_playing(0, "r s $ left up <beat 1/2>\nr $ slow 3/2 left\ns $ up")
    check_playing(1.9, "r s $ left up <beat 2/2>\nr $ slow 3/2 left\ns $ up")
    check_playing(2, "r s $ left up\nr $ slow 3/2 left <beat 1/2>\ns $ up <beat 1/1>")
    check_playing(3.2, "r s $ left up\nr $ slow 3/2 left <beat 2/2>\ns $ up")
    check_playing(100, "x = left\nr $ repeat x <beat 101/∞>")
    check_playing(1, "r s $ canon 2 left <beat 2/3>")


def test_lines_of_later_scenes_count_from_their_scene() -> None:
    check_playing(1.5, "r $ left\ns $ repeat 2 up <beat 2/2>\n---\nr $ up up")
    check_playing(2.5, "r $ left\ns $ repeat 2 up\n---\nr $ up up <beat 1/2>")


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
