"""Robots that meet each other or hit something, found before any of them moves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score import encounters
from improv_core.score.meetings import RoomCheck, check_room
from improv_core.score.motion import Pose
from tests.score.brute_force import disagreements


def checked(program: str, toml: str = "") -> RoomCheck:
    """Check a program. Robots without a place stand 3 m apart along y, the first at the origin; they are 0.6 m wide,
    and a step is 2 m."""
    return check_room(score_of(analyze(program, read_robots(toml))))


def found(checked: RoomCheck) -> list[str]:
    """`ada bo 1.5 0.20 +3`: they meet at beat 1.5, come as near as 0.2 m, and meet three more times."""
    meetings = [
        f"{' '.join(each.robots)} {each.beat:.4g} {each.distance:.2f} +{each.more}" for each in checked.meetings
    ]
    return meetings + [f"{each.robot} {each.thing} {each.beat:.4g}" for each in checked.hits]


def check(program: str, expected: Sequence[str], toml: str = "") -> None:
    assert found(checked(program, toml)) == list(expected)


FACING = "ada $ right\nbo $ left\n---\n"
"""They stand 3 m apart and look at each other from beat 1 on."""


@pytest.mark.parametrize(
    ("program", "expected"),
    [
        (f"{FACING}ada $ forward", []),
        (f"{FACING}ada $ scale 1.2 forward", []),  # then they touch
        (f"{FACING}ada $ scale 1.2004 forward", []),  # nearer by less than a millimeter
        (f"{FACING}ada $ scale 1.2006 forward", ["ada bo 2 0.60 +0"]),
        (f"{FACING}ada $ scale 1.3 forward", ["ada bo 1.923 0.40 +0"]),
        (f"{FACING}ada bo $ forward", ["ada bo 1.6 0.00 +0"]),
        (f"beat 240\n{FACING}ada bo $ forward", ["ada bo 1.6 0.00 +0"]),
        (f"{FACING}ada $ forward rest\nbo $ rest forward", ["ada bo 2.201 0.00 +0"]),
        (f"{FACING}ada $ repeat 3 (forward backward)\nbo $ scale 1/4 forward", ["ada bo 1.96 0.50 +2"]),
        (f"{FACING}ada bo $ forward || up", ["ada bo 1.6 0.00 +0"]),
        ("ada $ up right scale 1.3 forward\nbo $ rest", []),  # above it
        ("ada $ scale 1/4 up right scale 1.3 forward\nbo $ rest", ["ada bo 2.923 0.40 +0"]),  # not high enough
        ("ada $ up right scale 3/2 forward down\nbo $ rest", ["ada bo 3.7 0.00 +0"]),  # lands on it
        (
            "ada $ rest\nbo $ repeat 2 (scale 1.3 strafeleft) repeat 2 (scale 1.3 straferight)",
            ["ada bo 0.9235 0.00 +1"],
        ),
        ("ada bo $ repeat (forward || left)", []),  # always 3 m apart
        ("ada bo cleo $ scale 1.3 straferight", []),
    ],
)
def test_robots_meet_that_come_nearer_than_both_their_radii(program: str, expected: Sequence[str]) -> None:
    check(program, expected)


@pytest.mark.parametrize(
    ("world", "program", "expected"),
    [
        ("walls = [[2, -9, 2, 9]]", "ada $ forward", ["ada wall 1 0.8505"]),
        ("walls = [[9, 9, 9, 8], [-1, 0.2, 1, 0.2]]", "ada $ rest", ["ada wall 2 0"]),
        ("walls = [[2, 0.3, 2, 9]]", "ada $ forward", []),
        ("circles = [{ x = 2.5, radius = 0.5 }]", "ada $ rest up forward", ["ada circle 1 2.851"]),
        ("boxes = [{ x = 3, width = 2, height = 0.1 }]", "ada $ forward", ["ada box 1 0.8505"]),
        ("boxes = [{ x = 3, width = 2, height = 0.1, heading = 90 }]", "ada $ forward", []),
        ("boxes = [{ width = 2, height = 2 }]", "ada $ forward", ["ada box 1 0"]),  # it starts inside
        ("size = [3.4, 3.4]", "ada $ (forward || left)", []),
        ("size = [3, 3]", "ada $ slow 2 forward repeat 3 forward", ["ada edge 1.201"]),
        ("size = [3, 3]\nmargin = 0.2", "ada $ slow 2 forward", ["ada edge 1.001"]),
        ("circles = [{ x = 3, radius = 0.5 }]\nmargin = 0.21", "ada $ forward", ["ada circle 1 0.9955"]),
        ("walls = [[2.5, -1, 2.5, 1]]\nmargin = 0.21", "ada $ forward", ["ada wall 1 0.9955"]),
        (
            "size = [3, 3]\ncircles = [{ x = 1.2, radius = 0.1 }]",
            "ada $ forward",
            ["ada circle 1 0.4005", "ada edge 0.6005"],
        ),
    ],
)
def test_a_robot_hits_each_thing_once(world: str, program: str, expected: Sequence[str]) -> None:
    check(program, expected, f"[robots.ada]\nstart = {{}}\n[world]\n{world}")


@pytest.mark.parametrize(
    ("program", "expected"),
    [
        ("ada $ down", ["ada ground 0"]),
        ("ada $ up forward down", []),
        ("ada $ up slow 2 (down || forward) down up", ["ada ground 3"]),
        ("ada $ repeat 9 (up scale 5/4 down)", ["ada ground 1.8"]),
    ],
)
def test_nobody_flies_below_the_ground(program: str, expected: Sequence[str]) -> None:
    check(program, expected)


@pytest.mark.parametrize(
    ("starts", "program", "expected"),
    [
        ("{ y = 0.5 }", "ada bo $ forward", ["ada bo 0 0.50 +0"]),  # too near all the time
        ("{ y = 0.6 }", "ada bo $ forward", []),
        ("{ x = 0.5 }", "ada $ backward forward\nbo $ rest", ["ada bo 0 0.50 +1"]),
        ("{}", "ada bo $ repeat (forward left)", ["ada bo 0 0.00 +0"]),
        ("{ x = 2.5 }", "ada $ forward\nbo $ rest", ["ada bo 0.9505 0.50 +0"]),
    ],
)
def test_robots_may_be_too_near_from_the_start(starts: str, program: str, expected: Sequence[str]) -> None:
    check(program, expected, f"[robots]\nada.start = {{}}\nbo.start = {starts}")


def test_robots_may_have_to_stay_farther_apart() -> None:
    check(f"{FACING}ada $ forward", [])
    check(f"{FACING}ada $ forward", ["ada bo 1.951 1.00 +0"], "[world]\nmargin = 0.5")


@pytest.mark.parametrize(
    ("program", "end", "is_all"),
    [
        ("ada bo $ forward left rest", 3, True),
        ("ada $ repeat (forward left)\nbo $ rest", 9, True),
        ("ada $ repeat (forward left)\nbo $ repeat (forward halfleft rest)", 24, True),
        ("ada $ rest repeat (forward left)\nbo $ repeat (forward left left)", 25, True),
        ("ada $ forward repeat (forward || left)\nbo $ rest", 5, True),
        ("ada bo $ repeat (forward || left) || repeat (rest right) || repeat left", 8, True),
        ("ada $ repeat left\nbo $ rest rest", 2, True),
        ("ada $ repeat forward\nbo $ rest", 1000, False),
        ("ada $ repeat up\nbo $ rest", 1000, False),
        ("ada $ repeat (forward scale 1/91 left)\nbo $ rest", 729, True),
        ("ada $ repeat (forward scale 1/200 left)\nbo $ rest", 1000, False),
        ("ada $ repeat choose (left right)\nbo $ rest", 1000, False),
        ("ada $ repeat (forward seed 3 choose (left right))\nbo $ rest", 9, True),  # always the same
        ("ada $ repeat 100000 forward\nbo $ rest", 1000, False),
        ("ada $ fast 4 repeat (forward left)\nbo $ slow 3 repeat (forward left)", 24, True),
        ("ada $ repeat forward", 0, True),  # it is alone
        ("ada $ until near repeat (forward left)\nbo $ rest", 4, True),
        ("ada $ pause not near (forward left)\nbo $ rest", 1, True),
    ],
)
def test_it_is_checked_until_all_have_ended_or_repeat_themselves(program: str, end: float, is_all: bool) -> None:
    result = checked(program)
    assert (result.end, result.is_all) == (end, is_all)


def test_a_score_that_never_repeats_is_checked_for_a_thousand_beats() -> None:
    crossing = "ada $ repeat {} rest repeat forward\nbo $ right forward"
    toml = "[robots]\nada.start = {}\nbo.start = { x = 1.5, y = 2 }"
    assert found(checked(crossing.format(990), toml)) == ["ada bo 990.5 0.00 +0"]
    assert found(checked(crossing.format(1000), toml)) == []


def test_a_meeting_that_comes_again_in_each_round_counts_once_a_round() -> None:
    check(
        f"{FACING}ada $ repeat (forward backward)\nbo $ repeat (scale 1/4 (forward backward))", ["ada bo 1.96 0.50 +0"]
    )


@pytest.mark.parametrize(
    "edited", ["ada $ left forward", "bo $ right forward", "cleo $ repeat (forward left)", "dan $ forward"]
)
def test_after_an_edit_it_finds_what_a_first_check_finds(edited: str) -> None:
    program = (
        "ada $ right repeat forward\nbo $ left forward\ncleo $ forward choose (left right) forward\ndan $ left left\n"
    )
    analysis = analyze(program, read_robots("[world]\nsize = [30, 30]"))
    first = check_room(score_of(analysis))
    start = program.index(edited[:3])
    after = analysis.edited(start, program.index("\n", start), edited)
    again = check_room(score_of(after), before=first.known)
    assert found(again) == found(check_room(score_of(after)))
    assert found(check_room(score_of(analysis), before=again.known)) == found(first)


def test_after_an_edit_only_pairs_with_a_changed_robot_are_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    followed = set()
    original = encounters._follow_pair

    def noting(one: encounters._Here, other: encounters._Here, *rest: object) -> None:
        followed.add(f"{one.name} {other.name}")
        original(one, other, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(encounters, "_follow_pair", noting)
    analysis = analyze("ada bo cleo $ repeat 2 (scale 3 forward left)\n")
    end = len(analysis.text)
    first = check_room(score_of(analysis))
    assert followed == {"ada bo", "ada cleo", "bo cleo"}
    followed.clear()
    words = check_room(score_of(analysis.edited(0, 0, "# moves all words\n")), before=first.known)
    assert not followed
    before = words.known
    check_room(score_of(analysis.edited(end, end, "cleo $ rest\n")), before=before)
    assert followed == {"ada cleo", "bo cleo"}


def test_a_score_that_plays_is_checked_from_where_robots_are() -> None:
    score = score_of(analyze("ada bo $ forward left\n"))
    entered = {"ada": Pose(0, 0), "bo": Pose(5, 0, heading=math.pi)}
    parts = {name: replace(part, begins=7, entered=entered[name]) for name, part in score.parts.items()}
    playing = replace(score, parts=parts, since=7)
    assert found(check_room(playing, 7)) == []
    nearer = {**parts, "bo": replace(parts["bo"], entered=Pose(4, 0, heading=math.pi))}
    assert found(check_room(replace(playing, parts=nearer), 8)) == ["ada bo 8 0.00 +0"]
    assert found(check_room(replace(playing, parts=nearer), 6)) == ["ada bo 7.85 0.00 +0"]


@pytest.mark.parametrize(
    ("program", "end"),
    [
        ("ada $ fast 100000 repeat (forward left)\nbo $ rest", 0),
        ("ada bo $ scale 10000000000000000000000000000000000000000 repeat (forward || left)", 4),
        ("ada bo $ repeat 1000000 (forward left)", 1000),
    ],
)
def test_too_much_work_is_checked_for_fewer_beats(program: str, end: float) -> None:
    assert checked(program).end == end


def test_a_thousand_robots_on_one_spot_are_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encounters, "MAX_WORK", 20_000)
    names = [f"r{number}" for number in range(100)]
    starts = "".join(f"[robots.{name}]\nstart = {{}}\n" for name in names)
    result = checked(f"{' '.join(names)} $ repeat (forward choose (left right))", starts)
    assert result.end == 0


@pytest.mark.parametrize("seed", [0, 1, 3, 8, 12])
def test_brute_force_finds_the_same(seed: int) -> None:
    assert disagreements(seed, beats=5) == []
