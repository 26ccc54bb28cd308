"""Some scenes played alone: the starts of robots and their movements, or the reason for a refusal."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from improv_core.ide.rehearsal import SENSED, rehearse, scenes_named
from improv_core.ide.selection import UnplayableError
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.timing import brief
from improv_core.robots.config import read_robots
from improv_core.score.movement import ENDLESS, Exact
from improv_core.score.music import Music
from improv_core.score.path import pose_at
from improv_core.score.walk import walk

THREE = """beat 60
anna bert at line 2
--- walk
anna $ forward left
--- bow
bert $ forward
--- home
anna $ forward
"""


def check(program: str, first: str | int | None, last: str | int | None, *expected: str, note: str = "") -> None:
    """Check the beats that each robot moves in each scene, and its start: `anna (2.0 0.0 90) 2:1`."""
    analysis = analyze(program)
    found = rehearse(analysis, scenes_named(analysis, first, last))
    score = score_of(found.analysis)
    rows = []
    for robot, part in score.parts.items():
        x, y, facing = part.start.x, part.start.y, math.degrees(part.start.heading)
        beats = " ".join(
            f"{index}:{_beats(each.duration)}" for index, each in enumerate(part.scenes, 1) if each.duration
        )
        rows.append(f"{robot} ({x:.1f} {y:.1f} {facing:.0f}) {beats}".strip())
    assert rows == list(expected)
    assert found.note == note


def _beats(duration: float | Exact) -> str:
    return "∞" if duration == ENDLESS or isinstance(duration, float) else str(brief(duration))


def refused(program: str, first: str | int | None, last: str | int | None, expected: str) -> None:
    analysis = analyze(program)
    with pytest.raises(UnplayableError) as refusal:
        rehearse(analysis, scenes_named(analysis, first, last))
    assert str(refusal.value) == expected


def test_robots_begin_where_they_are_when_the_first_scene_begins() -> None:
    check(THREE, None, None, "anna (0.0 1.0 0) 1:2 3:1", "bert (0.0 -1.0 0) 2:1")
    check(THREE, "walk", "walk", "anna (0.0 1.0 0) 1:2", "bert (0.0 -1.0 0)")
    check(THREE, "bow", "bow", "bert (0.0 -1.0 0) 2:1", "anna (2.0 1.0 90)")
    check(THREE, "home", None, "anna (2.0 1.0 90) 3:1", "bert (2.0 -1.0 0)")
    check(THREE, "bow", "home", "bert (0.0 -1.0 0) 2:1", "anna (2.0 1.0 90) 3:1")
    check(THREE, None, "bow", "anna (0.0 1.0 0) 1:2", "bert (0.0 -1.0 0) 2:1")


def test_scenes_without_names_have_numbers() -> None:
    unnamed = "anna at 0 0\nanna $ forward\n---\nanna $ left\n"
    check(unnamed, 2, 2, "anna (2.0 0.0 0) 2:1")
    refused(unnamed, 3, None, "there is no scene 3: this program has 2")
    refused(unnamed, 0, None, "there is no scene 0: this program has 2")


def test_an_unknown_scene_has_the_nearest_name() -> None:
    refused(THREE, "bov", None, "no scene is called `bov`: did you mean `bow`?")
    refused(THREE, "Bow", None, "no scene is called `Bow`: did you mean `bow`?")
    refused(THREE, "xxxxxx", None, "no scene is called `xxxxxx`: write one of `walk`, `bow`, `home`")
    refused("anna $ up", "bow", None, "no scene is called `bow`: write `--- bow` above its lines")


def test_scenes_go_downward_and_play_something() -> None:
    refused(THREE, "home", "walk", "scene walk is above scene home: write the upper scene first")
    refused(
        "anna $ up\n--- bow\n", "bow", None, "nothing plays in scene bow: write a line such as `anna $ forward` there"
    )
    refused("anna $ up\n--- bow\nanna $ lft", "bow", None, "line 3: `lft` is not defined: did you mean `left`?")


def test_dice_fall_as_in_the_whole_program() -> None:
    words = "choose (forward left right)"
    program = f"anna at 0 0\nanna $ repeat 9 {words}\n--- on\nanna $ repeat 20 {words}\n"
    whole = score_of(analyze(program)).parts["anna"]
    analysis = analyze(program)
    only = score_of(rehearse(analysis, scenes_named(analysis, "on", None)).analysis).parts["anna"]
    assert [each.velocity for each in walk(whole.movement)][9:] == [each.velocity for each in walk(only.movement)]
    ends = [pose_at(whole, 29), pose_at(only, 20)]
    (x, y), (other_x, other_y) = ((pose.x, pose.y) for pose in ends if pose)
    assert math.hypot(x - other_x, y - other_y) < 1e-9


def test_places_that_senses_decide_are_as_pictured() -> None:
    for movement, place in (
        ("until near forward left", "(2.0 0.0 90)"),
        ("until cue repeat forward", "(8.0 0.0 0)"),
        ("(pause not near forward) left", "(2.0 0.0 90)"),
        ("until not near forward", "(0.0 0.0 0)"),
    ):
        program = f"anna at 0 0\nanna $ {movement}\n--- on\nanna $ up"
        check(program, "on", None, f"anna {place} 2:1", note=SENSED)
    check("anna at 0 0\nanna $ forward\n--- on\nanna $ until near up", "on", None, "anna (2.0 0.0 0) 2:1")


def test_robots_with_unknown_places_begin_at_their_starts() -> None:
    program = "anna at 0 0\nanna $ repeat forward\n--- on\nanna $ up"
    check(program, "on", None, "anna (0.0 0.0 0) 2:1", note="robots begin at their starts, since scene 1 never ends")
    program = "anna at 0 0\nanna $ forward lft\n--- on\nanna $ up"
    why = "there is an error above: line 2: `lft` is not defined: did you mean `left`?"
    check(program, "on", None, "anna (0.0 0.0 0) 2:1", note=f"robots begin at their starts, since {why}")


def test_other_scenes_of_a_rehearsal_can_be_rehearsed() -> None:
    analysis = analyze(THREE)
    home = rehearse(analysis, scenes_named(analysis, "home", None))
    bow = rehearse(home.analysis, scenes_named(home.analysis, "bow", "bow"))
    assert bow.name == "scene bow"
    again = rehearse(analysis, scenes_named(analysis, "bow", "bow"))
    starts = [{name: part.start for name, part in score_of(each.analysis).parts.items()} for each in (bow, again)]
    assert starts[0] == starts[1]
    assert starts[0]["anna"] != score_of(analysis).parts["anna"].start


@pytest.mark.parametrize(
    ("first", "last", "name"),
    [
        ("bow", "bow", "scene bow"),
        ("bow", None, "from scene bow on"),
        (None, None, "all scenes"),
        (None, "bow", "scene walk to scene bow"),
        (3, None, "scene home"),
    ],
)
def test_a_rehearsal_names_its_scenes(first: str | int | None, last: str | int | None, name: str) -> None:
    analysis = analyze(THREE)
    assert rehearse(analysis, scenes_named(analysis, first, last)).name == name


@pytest.mark.parametrize(("first", "seconds"), [("walk", 0.5), ("bow", 2.5), ("home", 3.5)])
def test_the_song_of_a_rehearsal_begins_where_its_first_scene_does(first: str, seconds: float) -> None:
    robots = read_robots('[music]\nfile = "song.wav"\nfirst_beat = 0.5', Path("/dances/improv.toml"))
    analysis = analyze(THREE, robots)
    music = score_of(rehearse(analysis, scenes_named(analysis, first, None)).analysis).music
    assert music == Music("song.wav", "/dances", seconds)
