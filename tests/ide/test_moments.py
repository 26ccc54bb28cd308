"""The words that play, drawn under the program, even after an edit."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from fractions import Fraction

import pytest

from improv_core.ide.moments import MAX_WORDS, LitWords, Places, lit_words
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.score.movement import Exact
from improv_core.score.replay import Replay


def lit(
    replay: Replay, beat: float, played: Analysis, now: Analysis | None = None, silent: Collection[str] = ()
) -> LitWords:
    return lit_words(replay, beat, Places(played, now or played), lambda robot: robot in silent)


def words(played: Analysis, beat: float, now: Analysis | None = None, silent: Collection[str] = ()) -> list[str]:
    """Return the words that play at a beat, as they stand in the later version."""
    spans = lit(Replay(score_of(played)), beat, played, now, silent).spans
    return [(now or played).text[span.start : span.end] for span in spans]


PROGRAM = "step = forward [left right]\nr s $ repeat 2 step || up\nb $ slow 4 down\n"


def test_names_and_the_words_behind_them() -> None:
    played = analyze(PROGRAM)
    assert words(played, 0.5) == ["forward", "step", "up", "down"]
    assert words(played, 1.25) == ["down"]
    assert words(played, 4) == []


def test_a_word_is_lit_with_its_measure() -> None:
    played = analyze("arc n = left n*90deg radius 1m\nr $ forward 1.5m arc 2 left fast 2 up\n")
    assert words(played, 0.5) == ["forward 1.5m"]
    assert words(played, 1.5) == ["left n*90deg radius 1m", "arc"]
    assert words(played, 2.5) == ["left"]
    assert words(played, 0.5, played.edited(0, 0, "# up\n")) == ["forward 1.5m"]


def test_silent_robots_light_nothing() -> None:
    assert words(analyze(PROGRAM), 0.5, silent=["r", "s"]) == ["down"]


def test_the_words_of_body_parts_are_lit_while_they_play() -> None:
    played = analyze("r is puppet\nwave = to high left\nr $ right_arm wave || head ([up down] left) || forward up\n")
    assert words(played, 0.25) == ["to high", "wave", "up", "forward"]
    assert words(played, 0.75) == ["to high", "wave", "down", "forward"]
    assert words(played, 1.5) == ["left", "wave", "left", "up"]


def test_words_are_found_after_edits() -> None:
    played = analyze("step = forward [left right]\nr $ repeat step\n")
    later = played.edited(0, 0, "# ❤️ a step\r\n\r\n")
    assert words(played, 1.75, later) == ["right", "step"]
    place = later.text.index("repeat")
    edited = later.edited(place, place, "slow 2 ")
    assert words(played, 1.75, edited) == ["right", "step"]
    deleted = edited.edited(0, len(edited.text), "")
    assert words(played, 1.75, deleted) == []
    assert words(played, 1.75, deleted.edited(0, 0, played.text)) == ["right", "step"]


@pytest.mark.parametrize(
    ("at", "deleted", "inserted", "lit"),
    [
        ("right", 0, "up ", ["right"]),
        ("right", 0, "x", []),
        ("right", 1, "", []),
        ("right", 5, "left", []),
        (" down", 0, " up", ["right"]),
        (" down", 0, "x", []),
        (" down", 0, "\n\nr $ ", ["right"]),
    ],
)
def test_a_word_that_is_edited_is_dark(at: str, deleted: int, inserted: str, lit: list[str]) -> None:
    played = analyze("r $ repeat 2 left right down\n")
    place = played.text.index(at)
    assert words(played, 1) == ["left"]
    later = played.edited(place, place + deleted, inserted)
    assert words(played, 2, later) == lit


def test_lit_words_change_at_the_next_beat_of_any_robot() -> None:
    played = analyze("r $ forward slow 3 left\ns $ slow 1.5 left\n")
    replay = Replay(score_of(played))
    changes = []
    beat = 0.0
    while (until := lit(replay, beat, played).until) is not None:
        beat = float(until)
        changes.append(beat)
    assert changes == [1, 1.5, 4]
    assert lit(replay, 5, played) == LitWords([], None)


def test_the_words_of_names_within_names_are_limited() -> None:
    played = analyze("x = forward\n" + "x = x left\n" * (MAX_WORDS + 10) + "r $ x\n")
    assert len(words(played, 0)) == MAX_WORDS


def test_lit_words_follow_senses() -> None:
    played = analyze("r $ repeat (until near (repeat forward) left)\n")
    replay = Replay(score_of(played))
    edges: dict[Exact, bool | None] = {0: False, Fraction(5, 2): True, Fraction(11, 4): False, Fraction(9, 2): None}
    for edge, value in edges.items():
        replay.sense("r", "near", value, edge)
        replay.sense("s", "near", True, edge)
    shown = []
    for beat in (2, 2.5, 3, 4, 4.5):
        spans, until = lit(replay, beat, played)
        shown.append((" ".join(played.text[span.start : span.end] for span in spans), until))
    assert shown == [("forward", 2.5), ("until", 2.75), ("left", 4), ("forward", 4.5), ("", 5)]


def test_a_scene_that_began_late_is_counted_from_there() -> None:
    played = analyze("r $ until cue repeat forward\n---\nr $ left right\ns $ repeat 3 up\n---\nr $ backward\n")
    score = score_of(played)
    begins = {"r": 7, "s": 9}
    parts = {robot: replace(part, begins=begins[robot], scene=1) for robot, part in score.parts.items()}
    replay = Replay(replace(score, parts=parts, scene=1, since=7))
    shown = []
    for beat in (7.5, 8, 9, 12):
        spans, until = lit(replay, beat, played)
        shown.append((" ".join(played.text[span.start : span.end] for span in spans), until))
    assert shown == [("left", 8), ("right", 9), ("up", 10), ("backward", 13)]
