"""Which words play when, drawn under the program, also after it has been edited."""

from __future__ import annotations

from improv_core.ide.moments import MOST_MOMENTS, MOST_WORDS, playing
from improv_core.program.analysis import Analysis, analyze


def lit(played: Analysis, beat: float, now: Analysis | None = None) -> list[str]:
    """The words that play at a beat, as they stand in the later version."""
    now = now or played
    found = []
    for robot, stretch in playing(played, now).items():
        for moment in stretch.moments:
            if moment.start <= beat < moment.end:
                found += [f"{robot}: {now.text[span.start : span.end]}" for span in moment.spans]
    return found


PROGRAM = "step = forward [left right]\nr s $ repeat 2 step || up\n"


def test_names_and_the_words_behind_them() -> None:
    played = analyze(PROGRAM)
    assert lit(played, 0.5) == ["r: step", "r: forward", "r: up", "s: step", "s: forward", "s: up"]
    assert lit(played, 1.25) == []


def test_what_moved_is_found_and_what_was_edited_is_left_out() -> None:
    played = analyze("step = forward [left right]\nr $ repeat step\n")
    later = played.edited(0, 0, "# ❤️ a step\r\n\r\n")
    assert lit(played, 1.75, later) == ["r: step", "r: right"]
    place = later.text.index("repeat")
    edited = later.edited(place, place, "slow 2 ")
    assert lit(played, 1.75, edited) == ["r: right"]


def test_what_never_ends_comes_in_pieces() -> None:
    played = analyze("r $ repeat (forward left)\n")
    stretch = playing(played, played)["r"]
    assert (len(stretch.moments), stretch.until) == (MOST_MOMENTS, MOST_MOMENTS)
    later = playing(played, played, MOST_MOMENTS + 0.5)["r"]
    assert (later.moments[0].start, later.moments[0].end) == (MOST_MOMENTS + 0.5, MOST_MOMENTS + 1)


def test_names_within_names_come_in_pieces() -> None:
    played = analyze("x = forward\n" + "x = x left\n" * 1_000 + "r $ x\n")
    stretch = playing(played, played)["r"]
    assert len(stretch.moments) == MOST_WORDS // 1_000
    assert stretch.until == MOST_WORDS // 1_000
    assert playing(played, played, stretch.until)["r"].moments[0].start == stretch.until


def test_the_end_is_told() -> None:
    played = analyze("r $ forward left\n")
    stretch = playing(played, played)["r"]
    assert (stretch.moments[-1].end, stretch.until) == (2, None)
    assert playing(played, played, 9)["r"].moments == ()
