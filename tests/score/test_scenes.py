"""Scenes: the beats at which they begin, and the movements of each robot."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.score import algebra
from improv_core.score.equality import same
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, STILL, Exact, Movement
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part, Score
from improv_core.score.score_json import from_json, to_json
from improv_core.score.walk import walk
from tests.score.test_movement import finite_movements


def scenes(*programs: str) -> tuple[Movement, ...]:
    """Each is a robot's line in one scene."""
    return tuple(analyze(f"r $ {program}").robots["r"] if program else algebra.series(()) for program in programs)


def score_of(robots: Mapping[str, Sequence[Movement]]) -> Score:
    return Score(Fraction(60), {name: Part(name, tuple(each), TURTLESIM, Pose(), "") for name, each in robots.items()})


def played(part: Part, most: int = 8) -> list[tuple[Exact, str]]:
    """The beats at which words play; nothing is standing still."""
    found = []
    for moment, _ in zip(walk(part.movement), range(most), strict=False):
        found.append((moment.start, "still" if moment.velocity == STILL else "moves"))
    return found


def check(robots: Mapping[str, Sequence[str]], *begins: int, **performed: Sequence[tuple[Exact, str]]) -> Score:
    """Check the beats at which scenes begin, and the robots that move or stand from these beats on."""
    score = score_of({name: scenes(*lines) for name, lines in robots.items()})
    assert score.scene_begins == begins
    assert {name: played(score.parts[name]) for name in performed} == performed
    copy = from_json(json.loads(json.dumps(to_json(score))))
    assert copy.scene_begins == score.scene_begins
    assert {name: played(part) for name, part in copy.parts.items() if name in performed} == performed
    return score


def test_a_scene_begins_when_all_robots_are_done() -> None:
    check(
        {"a": ["forward left left", "backward"], "b": ["forward", "backward"]},
        0,
        3,
        a=[(0, "moves"), (1, "moves"), (2, "moves"), (3, "moves")],
        b=[(0, "moves"), (1, "still"), (3, "moves")],
    )


def test_a_scene_begins_on_a_whole_beat() -> None:
    score = check(
        {"a": ["slow 5/2 forward", "backward"], "b": ["forward", "backward"]},
        0,
        3,
        a=[(0, "moves"), (Fraction(5, 2), "still"), (3, "moves")],
        b=[(0, "moves"), (1, "still"), (3, "moves")],
    )
    assert score.beats == 4


def test_a_robot_without_a_line_stands_and_ends_with_its_last_scene() -> None:
    score = check(
        {"a": ["forward", "", "left"], "b": ["", "forward forward"]},
        0,
        1,
        3,
        a=[(0, "moves"), (1, "still"), (3, "moves")],
        b=[(0, "still"), (1, "moves"), (2, "moves")],
    )
    assert score.parts["b"].movement.duration == 3


def test_an_empty_scene_takes_no_time() -> None:
    check({"a": ["forward", "", "left"]}, 0, 1, 1, a=[(0, "moves"), (1, "moves")])


def test_below_an_endless_scene_nothing_is_performed() -> None:
    score = check(
        {"a": ["forward", "left", "right"], "b": ["", "repeat up"]},
        0,
        1,
        a=[(0, "moves"), (1, "moves")],
        b=[(0, "still"), *((beat, "moves") for beat in range(1, 8))],
    )
    assert score.beats == ENDLESS


def test_below_an_endless_first_scene_the_others_stay_stopped() -> None:
    score = check({"a": ["repeat up", ""], "b": ["left", "forward"], "c": ["", "forward"]}, 0, b=[(0, "moves")], c=[])
    assert score.parts["b"].movement.duration == 1


def test_one_scene_is_the_movement_itself() -> None:
    (movement,) = scenes("forward left")
    assert score_of({"a": [movement]}).parts["a"].movement is movement
    assert score_of({"a": []}).parts["a"].movement.duration == 0


def test_another_robot_moves_the_scenes_of_all() -> None:
    score = score_of({"a": scenes("forward", "left")})
    (other,) = scenes("slow 4 forward")
    parts = {**score.parts, "b": Part("b", (other,), TURTLESIM, Pose(), "")}
    assert played(replace(score, parts=parts).parts["a"]) == [(0, "moves"), (1, "still"), (4, "moves")]


@pytest.mark.parametrize("scene", [-1, 1, 10**9])
def test_a_scene_that_is_missing_is_refused(scene: int) -> None:
    data = json.loads(json.dumps(to_json(score_of({"a": scenes("forward")}))))
    data["parts"]["a"]["scenes"] = [0, scene] if scene > 1 else [scene, 10**6]
    with pytest.raises((ValueError, IndexError)):
        from_json(data)


@given(st.lists(st.lists(finite_movements, max_size=3), max_size=3))
def test_each_scene_is_performed_as_by_itself(robots: list[list[Movement]]) -> None:
    """And none begins before all robots have ended the scene above."""
    score = score_of({f"r{number}": each for number, each in enumerate(robots)})
    for part in score.parts.values():
        for index, (scene, begin) in enumerate(zip(part.scenes, score.scene_begins, strict=False)):
            expected = [(begin + moment.start, moment.velocity) for moment in walk(scene)]
            found = walk(part.movement, begin) if expected else iter(())
            assert [(moment.start, moment.velocity) for moment, _ in zip(found, expected, strict=False)] == expected
            assert begin + scene.duration <= [*score.scene_begins, ENDLESS][index + 1]
        assert part.movement.duration == sum(moment.duration for moment in walk(part.movement))


def test_a_scene_that_shifts_is_still_the_same() -> None:
    """A save compares the scene that plays."""
    before = score_of({"a": scenes("forward", "left"), "b": scenes("forward", "right")})
    after = score_of({"a": scenes("forward", "left"), "b": scenes("slow 2 forward", "right")})
    assert not same(before.parts["a"].movement, after.parts["a"].movement)
    assert all(map(same, before.parts["a"].scenes, after.parts["a"].scenes))
