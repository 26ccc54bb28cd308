"""Robots that come too near to each other: poses and their times → the pairs, and the player's acts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.player.separation_monitor import QUIET, from_elsewhere
from improv_core.protocol.messages import RobotsSeen
from improv_core.protocol.output import RawPose
from improv_core.safety.odometry import CONTINUOUS
from improv_core.safety.separation import MAX_NAMED, PATIENCE, Near, Proximity, as_line
from improv_core.safety.stopping_distance import JITTER, Base
from improv_core.score.motion import Pose
from improv_core.score.profiles import CREATE3, TURTLEBOT4
from improv_core.score.score import Host, OdomFrame, Safety
from improv_core.score.world import World
from tests.player.test_player import Stage, score

KEEP_APART = 0.3
RADIUS = 0.1


def seen(at: float, **places: float) -> list[RawPose]:
    """The poses of robots along the x axis at a time. The first one looks away from the others."""
    return [
        RawPose(robot, CONTINUOUS, Pose(x, heading=math.pi if robot == "a" else 0.0), at) for robot, x in places.items()
    ]


BASES = dict.fromkeys("abc", Base(RADIUS))


def check(*steps: tuple[float, float], expected: Sequence[float]) -> None:
    """Check the times at which two robots are too near. The gaps between their edges are seen as `(time, gap)`."""
    bases = dict.fromkeys("ab", Base(RADIUS))
    nearness, found = Proximity(), []
    for now, gap in steps:
        nearness = nearness.heard(seen(now, a=0, b=gap + 2 * RADIUS), bases)
        nearness, near, _ = nearness.looked(True, bases, KEEP_APART, now)
        found += [now for _ in near]
    assert found == list(expected)


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ([(0, 0.5), (1, 0.31), (2, 0.31)], []),
        ([(0, 0.5), (1, 0.29)], [1]),  # at once
        ([(0, 0.5), (1, -0.1)], [1]),
        # They begin too near to each other, and move apart:
        ([(0, 0.1), (1, 0.15), (2.5, 0.2), (4, 0.29), (5, 0.31)], []),
        # ... or not:
        ([(0, 0.1), (0.1, 0.06)], [0.1]),
        ([(0, 0.1), (1, 0.11), (PATIENCE, 0.11)], [PATIENCE]),
        ([(0, 0.1), (1, 0.1 - JITTER / 2), (1.5, 0.2), (1.6, 0.16)], [1.6]),
        ([(0, 0.1), (1, 0.2), (1 + PATIENCE, 0.2)], [1 + PATIENCE]),
        # After they have been apart, coming near again counts at once:
        ([(0, 0.1), (1, 0.4), (2, 0.28)], [2]),
    ],
)
def test_robots_that_come_too_near_are_found(steps: list[tuple[float, float]], expected: list[float]) -> None:
    check(*steps, expected=expected)


def test_robots_may_be_brought_together_while_they_do_not_play() -> None:
    nearness, *_ = Proximity().heard(seen(0, a=0, b=1), BASES).looked(True, BASES, KEEP_APART, 0)
    nearness, near, _ = nearness.heard(seen(1, a=0, b=0.3), BASES).looked(False, BASES, KEEP_APART, 1)
    assert near == []
    assert nearness.heard(seen(2, a=0, b=0.3), BASES).looked(True, BASES, KEEP_APART, 2).found == []


def test_a_pose_that_is_old_shows_nothing() -> None:
    nearness = Proximity().heard([*seen(0, a=0), *seen(0.15, b=1)], BASES)
    nearness, *_ = nearness.looked(True, BASES, KEEP_APART, 0.15)
    nearness = nearness.heard([*seen(0.25, b=0.1), *seen(0.26, b=0.1)], BASES)
    assert nearness.looked(True, BASES, KEEP_APART, 0.26).found == []
    (near,) = nearness.heard(seen(0.27, a=0), BASES).looked(True, BASES, KEEP_APART, 0.27).found
    assert near.robots == ("a", "b")


places = st.dictionaries(
    st.sampled_from([f"r{number}" for number in range(30)]),
    st.tuples(st.floats(-3, 3), st.floats(-3, 3)),
    min_size=2,
)


@given(places, st.floats(0.05, 0.5))
def test_all_pairs_are_found_and_no_others(where: Mapping[str, tuple[float, float]], radius: float) -> None:
    poses = [RawPose(robot, CONTINUOUS, Pose(x, y), 1.0) for robot, (x, y) in where.items()]
    far = [RawPose(robot, CONTINUOUS, Pose(100.0 * index), 0.0) for index, robot in enumerate(where)]
    bases = dict.fromkeys(where, Base(radius))
    nearness, none, _ = Proximity().heard(far, bases).looked(True, bases, KEEP_APART, 0.0)
    assert none == []
    found = {frozenset(near.robots) for near in nearness.heard(poses, bases).looked(True, bases, KEEP_APART, 1.0).found}
    names = list(where)
    expected = {
        frozenset((one, other))
        for index, one in enumerate(names)
        for other in names[:index]
        if Pose(*where[one]).apart(Pose(*where[other]))[0] - 2 * radius < KEEP_APART
    }
    assert found == expected


def test_a_near_pair_is_found_by_the_stages_that_move_it() -> None:
    proximity, *_ = Proximity().heard(seen(0, a=0, b=3, c=6), BASES).looked(True, BASES, KEEP_APART, 0)
    proximity = proximity.heard(seen(1, a=0, b=0.4, c=0.8), BASES)
    for ours, expected in (({"a"}, ["ab"]), ({"b"}, ["ab", "bc"]), (set[str](), []), (None, ["ab", "bc"])):
        found = proximity.looked(True, BASES, KEEP_APART, 1, ours).found
        assert sorted("".join(each.robots) for each in found) == expected


def test_a_line_names_the_nearest_pairs() -> None:
    pairs = [Near(("a", "b"), -0.02), *(Near(("c", f"r{number}"), 0.2) for number in range(MAX_NAMED + 1))]
    assert as_line(pairs[:1], 0.3) == (
        "paused: a and b are 0.00 m apart, and `keep_apart` is 0.3 m: make room, then resume"
    )
    assert as_line(pairs, 0.3).startswith("paused: a and b are 0.00 m apart, c and r0 are 0.20 m apart, ")
    assert "(and 2 more pairs)" in as_line(pairs, 0.3)


# The player


def playing(
    *,
    frame: OdomFrame = "world",
    keep_apart: float | None = KEEP_APART,
    poses: bool = True,
    elsewhere: bool = False,
    host: str = "",
    sight: bool = False,
    real: bool = True,
    seconds: float = 1.0,
    program: str = "beat 60\na b $ repeat 80 forward",
) -> Stage:
    """Two real robots that have driven for so long, with 3 m between their edges. Another stage may move `b`. With
    `sight`, both stand while one of them isn't seen."""
    stage = Stage()
    stage.sink.real = real
    read = score(program)
    parts = {
        robot: replace(
            part,
            odom=f"/{robot}/pose" if poses else None,
            odom_frame=frame,
            profile=CREATE3,
            host=Host("pad") if elsewhere and robot == "b" else None,
        )
        for robot, part in read.parts.items()
    }
    dance = replace(read, parts=parts, world=World(keep_apart=keep_apart), safety=Safety(sight=sight))
    if sight:
        see(stage, 3)
    stage.perform(dance.on(host) if elsewhere else dance, anyway=True)
    stage.run(seconds)
    if elsewhere:
        see_here(stage)
        see_there(stage, 3)
    else:
        see(stage, 3)
    return stage


def see(stage: Stage, gap: float) -> None:
    """Send poses of both robots, with this many meters between their edges. The second one shows no jump."""
    wide = sum(part.profile.radius for part in stage.player.run.score.parts.values())
    for _ in twice(stage):
        stage.player.measure(seen(stage.now, a=0, b=gap + wide), stage.now)


def twice(stage: Stage) -> Iterator[None]:
    yield
    stage.run(0.01)
    yield


def paused(stage: Stage) -> bool:
    zeros = [command for robot in "ab" for command in stage.sink.changes(robot)[-1:] if command[1:] == (0, 0)]
    return stage.states[-1] == "paused" and len(zeros) == 2


def unguarded(stage: Stage) -> list[str]:
    return [line for line in stage.lines if "doesn't guard" in line]


def test_robots_too_near_to_each_other_pause_at_once_until_a_person_resumes() -> None:
    stage = playing()
    see(stage, 0.31)
    assert stage.states[-1] == "playing"
    see(stage, 0.2)
    assert paused(stage)
    assert stage.lines[-1] == "paused: a and b are 0.20 m apart, and `keep_apart` is 0.3 m: make room, then resume"
    assert stage.transports[-1].get("too_near") == ("a", "b")
    assert stage.transports[-1].get("resumes") == {"scene": 0.0, "beat": stage.transports[-1]["beat"]}
    see(stage, 2)
    stage.run(5)
    assert paused(stage)
    stage.ask("resume", beat=stage.transports[-1]["beat"], anyway=True)
    assert stage.states[-1] == "playing"
    assert not {"too_near", "resumes"} & stage.transports[-1].keys()


@pytest.mark.parametrize(
    "stage", [playing(frame="own"), playing(keep_apart=None), playing(poses=False)], ids=["own", "unset", "unseen"]
)
def test_only_robots_with_poses_in_the_world_are_guarded(stage: Stage) -> None:
    see(stage, 0.1)
    assert stage.states[-1] == "playing"


def test_robots_that_are_not_guarded_are_named_once() -> None:
    stage = playing(frame="own")
    stage.run(1)
    assert unguarded(stage) == ['`keep_apart` doesn\'t guard a, b: that needs poses with `odom_frame = "world"`']
    assert unguarded(playing(keep_apart=None)) == []


def meet(stage: Stage, gap: float) -> None:
    """Send poses of both robots, which look at each other, with this many meters between their edges."""
    wide = sum(part.profile.radius for part in stage.player.run.score.parts.values())
    for _ in twice(stage):
        places = {"a": Pose(), "b": Pose(gap + wide, heading=math.pi)}
        stage.player.measure([RawPose(robot, CONTINUOUS, pose, stage.now) for robot, pose in places.items()], stage.now)


def test_robots_that_drive_toward_each_other_pause_while_they_still_have_room_to_brake() -> None:
    """At 0.2 m/s, each needs 0.02 m to react and 0.022 m to brake; until the second pose comes, each drives 0.002 m."""
    stage = playing()
    meet(stage, 0.39)
    assert stage.states[-1] == "playing"
    meet(stage, 0.38)
    assert paused(stage)
    assert stage.lines[-1] == (
        "paused: a and b are 0.38 m apart and approach at 0.40 m/s, and `keep_apart` is 0.3 m: make room, then resume"
    )


def test_a_command_that_has_robots_drive_toward_each_other_counts_at_once() -> None:
    """They turn for two beats, and then look at each other."""
    stage = playing(program="beat 60\na b $ left left repeat 8 forward")
    meet(stage, 0.31)
    stage.run(0.9)
    meet(stage, 0.31)
    assert stage.states[-1] == "playing"
    stage.run(0.2)
    assert paused(stage)


def test_one_pose_that_jumps_pauses_nobody_until_the_next_one_agrees() -> None:
    stage = playing()
    wide = 2 * CREATE3.radius
    for gap, state in [(3.0, "playing"), (0.2, "playing"), (3.0, "playing"), (0.1, "playing"), (0.1, "paused")]:
        stage.run(0.05)
        stage.player.measure(seen(stage.now, a=0, b=gap + wide), stage.now)
        assert stage.states[-1] == state


# Robots that stages elsewhere move


def see_here(stage: Stage) -> None:
    stage.player.measure(seen(stage.now, a=0), stage.now)


def see_there(stage: Stage, gap: float, *, ago: float = 0.0, robot: str = "b", told: float | None = None) -> None:
    """Send the pose of the robot elsewhere this many seconds ago, with this many meters between the edges."""
    wide = sum(part.profile.radius for part in stage.player.run.score.parts.values())
    where = {"x": gap + wide, "y": 0.0, "z": 0.0, "heading": 0.0}
    for _ in twice(stage):
        command = {} if told is None else {"told": [told, 0.0, 0.0, 0.0]}
        message: Any = {"type": "seen", "robots": {robot: {"at": stage.now - ago, "pose": where, **command}}}
        stage.player.measure(from_elsewhere(message, stage.player.run.score, stage.now), stage.now)


def told_elsewhere(stage: Stage) -> list[RobotsSeen]:
    return [message for message in stage.told if message["type"] == "seen"]


def test_a_pose_from_another_stage_that_is_old_shows_nothing_and_none_is_newer_than_now() -> None:
    stage = playing(elsewhere=True)
    see_there(stage, 0.2, ago=0.52)
    assert stage.states[-1] == "playing"
    see_there(stage, 0.2, ago=-60)
    assert stage.states[-1] == "paused"
    stage = playing(elsewhere=True)
    see_there(stage, 3, ago=-60)
    stage.run(0.6)
    stage.player.measure(seen(stage.now, a=3), stage.now)
    assert stage.states[-1] == "playing"


def test_commands_of_another_stage_take_room() -> None:
    """Backward is toward ours. It needs 0.05 m to brake, 0.03 m to react, and twice 0.03 m for a pose 0.1 s old, since
    its stage knows as late about ours."""
    stage = playing(elsewhere=True)
    see_there(stage, 0.43, ago=0.1, told=0.3)
    assert stage.states[-1] == "playing"
    for _ in range(20):
        see_here(stage)
        see_there(stage, 0.45, ago=0.1, told=-0.3)
    assert stage.states[-1] == "playing"
    see_there(stage, 0.43, ago=0.1, told=-0.3)
    assert stage.states[-1] == "paused"


def test_a_report_of_another_stage_about_a_robot_here_is_ignored() -> None:
    stage = playing(elsewhere=True)
    see_there(stage, 0.1)
    assert stage.states[-1] == "paused"
    stage = playing(elsewhere=True)
    see_there(stage, 3 - 2.9, robot="a")
    assert stage.states[-1] == "playing"


def test_robots_elsewhere_of_which_no_poses_come_are_named_and_again_only_after_a_quiet_while() -> None:
    stage = playing(elsewhere=True)

    def poses_come(seconds: float, *, there: bool = True) -> None:
        for _ in range(round(seconds / 0.1)):
            see_here(stage)
            if there:
                see_there(stage, 3)
            stage.run(0.1)

    lost = "`keep_apart` doesn't guard b now: no pose came for 0.5 s"
    poses_come(QUIET + 2)
    before = stage.lines.count(lost)
    for there in (False, True, False):
        poses_come(2, there=there)
    assert stage.lines.count(lost) == before + 1
    poses_come(QUIET + 2)
    poses_come(2, there=False)
    assert stage.lines.count(lost) == before + 2


def test_nobody_here_waits_until_a_robot_elsewhere_is_in_its_place() -> None:
    stage = Stage()
    stage.sink.real = True
    read = score("beat 60\na b $ repeat 8 forward")
    there = replace(read.parts["b"], odom="/b/pose", odom_frame="world", host=Host("pad"), profile=TURTLEBOT4)
    stage.perform(replace(read, parts={**read.parts, "b": there}).on(""))
    assert stage.states[-1] == "playing"


def test_stages_elsewhere_get_the_poses_of_robots_here_while_they_play_or_pause() -> None:
    stage = playing(elsewhere=True)
    (said,) = told_elsewhere(stage)
    pose = {"x": 0, "y": 0.0, "z": 0.0, "heading": math.pi}
    assert said["robots"] == {"a": {"at": 1001.0, "pose": pose, "told": (0.2, 0.0, 0.0, 0.0)}}
    stage.ask("pause")
    see_here(stage)
    assert len(told_elsewhere(stage)) == 2
    stage.ask("stop")
    see_here(stage)
    assert len(told_elsewhere(stage)) == 2


def test_if_nobody_is_elsewhere_no_stage_gets_them_and_if_nobody_keeps_apart_once_a_second() -> None:
    assert told_elsewhere(playing()) == []
    stage = playing(elsewhere=True, keep_apart=None)
    for _ in range(29):
        stage.run(0.1)
        see_here(stage)
    assert [round(each["robots"]["a"]["at"] - 1001) for each in told_elsewhere(stage)] == [0, 1, 2]


@pytest.mark.parametrize("keep_apart", [None, KEEP_APART])
@pytest.mark.parametrize(("frames", "differ"), [(("map", "odom"), True), (("map", "/map"), False)])
def test_one_stage_has_a_line_about_robots_on_several_hosts_with_different_frames(
    keep_apart: float | None, frames: tuple[str, str], differ: bool
) -> None:
    stages = {
        robot: playing(elsewhere=True, host=host, keep_apart=keep_apart) for robot, host in (("a", ""), ("b", "pad"))
    }
    for _ in range(12):
        for (robot, stage), frame in zip(stages.items(), frames, strict=True):
            stage.run(0.1)
            here = RawPose(robot, CONTINUOUS, Pose(3.0 if robot == "b" else 0.0), stage.now, frame)
            stage.player.measure([here], stage.now)
        for robot, stage in stages.items():
            (other,) = (each for name, each in stages.items() if name != robot)
            for seen_there in told_elsewhere(other)[-1:]:
                stage.player.measure(from_elsewhere(seen_there, stage.player.run.score, stage.now), stage.now)
    lines = [[line for line in stage.lines if "different frames" in line] for stage in stages.values()]
    line = (
        "poses in the world have different frames: a in 'map' and b in 'odom'; no check and no correction uses those "
        "of a and b: publish all in one frame"
    )
    assert lines == [[line] if differ else [], []]


# Robots that must be seen


def test_all_stand_while_one_of_them_is_not_seen() -> None:
    stage = playing(keep_apart=None, sight=True, seconds=0.1)
    for _ in range(4):
        stage.run(0.0499)
        see_here(stage)
    assert stage.states[-1] == "playing"
    stage.run(0.001)
    assert paused(stage)
    assert stage.lines[-1] == "paused: a pose of b didn't come for 0.2 s"
    assert stage.transports[-1].get("waits_for") == ["a pose of b"]
    stage.run(1)
    assert paused(stage)
    see(stage, 3)
    assert stage.states[-1] == "playing"


def test_poses_that_are_late_again_and_again_are_reported_once() -> None:
    stage = playing(keep_apart=None, sight=True, seconds=0.1)
    for _ in range(20):
        stage.run(0.3)
        assert paused(stage)
        see(stage, 3)
        assert stage.states[-1] == "playing"
    assert stage.lines.count("paused: a pose of a didn't come for 0.2 s") == 1
    stage.run(11)
    see(stage, 3)
    stage.run(0.3)
    assert stage.lines.count("paused: a pose of a didn't come for 0.2 s") == 2


def test_a_pose_that_is_late_is_as_old_as_its_stamp_says() -> None:
    stage = playing(keep_apart=None, sight=True, seconds=0.1)
    for _ in range(40):
        stage.run(0.04)
        late = [raw._replace(stamp=raw.at - 0.17) for raw in seen(stage.now, a=0, b=3)]
        stage.player.measure(late, stage.now)
    assert "paused" in stage.states


def test_simulated_robots_need_not_be_seen() -> None:
    stage = playing(keep_apart=None, sight=True, real=False, seconds=0.1)
    stage.run(5)
    assert stage.states[-1] == "playing"
