"""Which words play when, drawn under the program, also after it has been edited."""

from __future__ import annotations

from fractions import Fraction

from improv_core.ide.moments import MOST_MOMENTS, MOST_WORDS, SoFar, playing
from improv_core.program.analysis import Analysis, analyze
from improv_core.score.performance import SenseEdge


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


def test_moved_words_are_found_and_edited_ones_left_out() -> None:
    played = analyze("step = forward [left right]\nr $ repeat step\n")
    later = played.edited(0, 0, "# ❤️ a step\r\n\r\n")
    assert lit(played, 1.75, later) == ["r: step", "r: right"]
    place = later.text.index("repeat")
    edited = later.edited(place, place, "slow 2 ")
    assert lit(played, 1.75, edited) == ["r: right"]


def test_endless_parts_come_in_pieces() -> None:
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


def words(played: Analysis, so_far: SoFar, start: float = 0.0) -> list[tuple[float, float, str]]:
    moments = playing(played, played, start, so_far)["r"].moments[:4]
    return [
        (each.start, each.end, " ".join(played.text[span.start : span.end] for span in each.spans)) for each in moments
    ]


def test_moments_follow_what_senses_decided() -> None:
    played = analyze("r $ repeat (until near (repeat forward) left)\n")
    edges = [SenseEdge(0, "r", "near", False), SenseEdge(0, "s", "near", True)]
    assert words(played, SoFar(edges=edges))[:2] == [(0, 1, "forward"), (1, 2, "forward")]
    edges += [SenseEdge(Fraction(5, 2), "r", "near", True), SenseEdge(Fraction(11, 4), "r", "near", False)]
    assert words(played, SoFar(edges=edges), 2) == [
        (2, 2.5, "forward"),
        (2.5, 2.75, "until"),
        (2.75, 3, "until"),
        (3, 4, "left"),
    ]


def test_a_scene_that_began_late_is_counted_from_there() -> None:
    played = analyze("r $ until cue repeat forward\n---\nr $ left right\ns $ repeat 3 up\n---\nr $ backward\n")
    so_far = SoFar({"r": 7.0, "s": 9.0}, 1, 7.0)
    assert words(played, so_far, 7.5) == [(7.5, 8, "left"), (8, 9, "right"), (9, 12, ""), (12, 13, "backward")]
