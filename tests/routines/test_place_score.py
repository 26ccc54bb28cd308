"""The scores with which robots drive to their places: their ends, their speeds, and the rules that stop them."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.routines.place_plan import DrivePath
from improv_core.routines.place_score import LEG, LOOK, driving, looking, undrivable
from improv_core.score.motion import Pose
from improv_core.score.path import pose_at
from improv_core.score.profiles import DEFAULT, SLOW, SLOW_TURN, TURTLEBOT4, Profile
from improv_core.score.score import Deadman, Part, Safety, Score, twist
from improv_core.score.score_json import from_json, to_json
from improv_core.score.walk import walk

WHEELS = replace(TURTLEBOT4, motions=("forward", "turn"))
POSES = {"a": Pose(), "b": Pose(9)}


def dance(profile: Profile = WHEELS) -> Score:
    read = score_of(analyze("a b $ forward"))
    parts = {
        robot: replace(part, profile=profile, odom=f"/{robot}/pose", odom_frame="world", reset="/reset")
        for robot, part in read.parts.items()
    }
    return replace(read, parts=parts, safety=Safety(stop="/e_stop", deadman=Deadman("/joy", 4)))


def drives(points: Sequence[tuple[float, float]], heading: float | None = 0.0, profile: Profile = WHEELS) -> Score:
    """The score with which `a` drives along these points, while `b` stands 9 m away."""
    return driving(dance(profile), POSES, {"a": DrivePath(points, heading)})


def end(part: Part) -> Pose:
    found = pose_at(part, part.movement.duration)  # type: ignore[arg-type]
    assert found
    return found


@pytest.mark.parametrize(
    ("points", "heading"),
    [
        ([(1.0, 2.0)], 0.5),
        ([(-1.0, 0.3), (2.0, 1.0)], -3.0),
        ([], 2.0),
        ([(-0.1, 0.0)], 0.0),  # it drives backward
        ([(0.5, 0.5)], None),  # it only makes room
    ],
)
def test_a_robot_ends_in_its_place(points: list[tuple[float, float]], heading: float | None) -> None:
    found = end(drives(points, heading).parts["a"])
    assert (found.x, found.y) == pytest.approx(points[-1] if points else (0, 0), abs=1e-4)
    if heading is not None:
        assert abs(math.remainder(found.heading - heading, math.tau)) < 1e-4


def test_a_robot_drives_backward_to_a_point_close_behind_it() -> None:
    assert [moment.velocity.yaw for moment in walk(drives([(-0.1, 0.0)]).parts["a"].movement)] == [0]


@pytest.mark.parametrize(("profile", "linear", "angular"), [(WHEELS, 0.306 / 5, 1.9 / 5), (DEFAULT, SLOW, SLOW_TURN)])
def test_robots_are_slow(profile: Profile, linear: float, angular: float) -> None:
    score = drives([(0.2, 0.3)], profile=profile)
    told = [twist(moment.velocity, profile, score.tempo) for moment in walk(score.parts["a"].movement)]
    assert max(abs(each.x) for each in told) == pytest.approx(linear)
    assert max(abs(each.yaw) for each in told) == pytest.approx(angular)


def test_a_robot_that_can_not_follow_its_way_is_measured_again_after_a_leg() -> None:
    for profile, follows, far in ((DEFAULT, False, LEG - 0.3), (WHEELS, True, 4)):
        part = drives([(0.3, 0.0), (0.3, 4.0)], 1.0, profile).parts["a"]
        assert part.follow is follows
        assert end(part).y == pytest.approx(far, abs=1e-4)


def test_all_robots_are_in_the_score_until_its_end_and_must_be_seen() -> None:
    score = drives([(1.0, 0.0)])
    assert {robot: part.start for robot, part in score.parts.items()} == POSES
    assert score.parts["a"].movement.duration == pytest.approx(score.parts["b"].movement.duration, abs=1e-5)
    assert end(score.parts["b"]) == Pose(9)
    assert not any(part.stands or part.reset for part in score.parts.values())
    assert (score.safety.sight, score.safety.stop, score.safety.deadman) == (True, "/e_stop", Deadman("/joy", 4))
    assert score.safety.faults.response("stuck") == "stop"


def test_robots_only_stand_while_their_poses_are_found_out() -> None:
    score = looking(dance())
    assert score.safety.sight
    assert [end(part) for part in score.parts.values()] == [part.start for part in score.parts.values()]
    assert score.beats == LOOK


def test_a_stage_can_read_the_score() -> None:
    score = drives([(1.0, 1 / 3)], 0.1)
    assert from_json(json.loads(json.dumps(to_json(score)))).safety == score.safety


@pytest.mark.parametrize(
    ("changed", "profile", "why"),
    [
        ({}, WHEELS, None),
        ({}, DEFAULT, None),
        ({"odom": None}, WHEELS, "poses are not in the world"),
        ({"odom_frame": "own"}, WHEELS, "poses are not in the world"),
        ({}, replace(WHEELS, motions=("forward", "strafe")), "can't turn on the spot"),
        ({}, replace(WHEELS, turning_radius=0.5), "can't turn on the spot"),
    ],
)
def test_robots_that_can_not_drive_to_their_places_are_refused(
    changed: dict[str, str], profile: Profile, why: str | None
) -> None:
    found = undrivable(replace(dance(profile).parts["a"], **changed))  # type: ignore[arg-type]
    assert (found is None) if why is None else (found and why in found)
