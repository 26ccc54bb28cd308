"""Missing body parts, directions, and poses, and limits of joints, drawn under the program."""

from __future__ import annotations

import json
import math

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled
from improv_core.program.joint_check import check_joints
from improv_core.program.script import read_script
from improv_core.robots.config import read_robots
from tests.program.drawing import check

PUPPET = '[profiles.p]\nbase = "puppet"\n[robots.r1]\nprofile = "p"\n[robots.r2]\nprofile = "turtlesim"\n'
FAST = """
[profiles.a]
step = 1
[profiles.a.body.head]
left = { joint = "yaw", degrees = 30 }
[profiles.a.body.head.poses]
far = { left = 100 }
[profiles.a.joints.yaw]
min = -119.5
max = 119.5
max_velocity = 45
[robots.r]
profile = "a"
"""


def check_puppets(expected: str) -> None:
    check(expected, robots=PUPPET)


def test_each_use_of_a_part_that_robots_lack_is_marked_with_their_names() -> None:
    lacks = "`r2` has no `head`, so this rests: give a profile with it in improv.toml"
    check_puppets(f"""
        x = head left
        r1 r2 $ head up x
                ^^^^ no-such-part: {lacks}
                        ^ no-such-part: {lacks}
    """)


def test_the_base_ignores_words_under_parts() -> None:
    robots = PUPPET.replace('base = "puppet"', 'base = "puppet"\nmotions = ["forward", "turn"]\nmax_linear = 1')
    check("r1 $ left_arm (up fast 10 down) || forward", robots=robots)


def test_a_pose_that_only_this_part_lacks_is_a_warning() -> None:
    analysis = analyze("r1 $ head to high", read_robots(PUPPET))
    assert [(each.code, each.severity.value) for each in analysis.diagnostics] == [("no-such-pose", "warning")]
    assert analysis.ok


def test_a_direction_that_a_part_lacks_is_marked_through_names_and_phrases() -> None:
    lacks = "`head` has no direction `forward`, so `forward` and `backward` do nothing: use another, or declare it in"
    lacks += " the profile p"
    check_puppets(f"""
        x = backward
        twice (m) = m m
        nod = head x
        r1 $ head x nod
                  ^ part-direction: {lacks}
                    ^^^ part-direction: {lacks}
        r1 $ head twice (up forward)
                            ^^^^^^^ part-direction: {lacks}
        r1 $ head twice x || twice forward
                        ^ part-direction: {lacks}
        r1 $ reflect YZ head forward
                             ^^^^^^^ part-direction: {lacks}
    """)


def test_a_pose_that_a_part_lacks_is_marked_through_names() -> None:
    check_puppets("""
        x = to high
        r1 $ head x left_arm x
                  ^ no-such-pose: `head` has no pose `high`, so it rests: declare it in the profile p
    """)


def test_poses_beside_other_voices_are_marked_through_names() -> None:
    why = "another voice moves `left_shoulder_pitch` too, so it ends elsewhere: play one after the other"
    check_puppets(f"""
        x = left_arm (up || to high)
        y = reflect sagittal right_arm to high
        r1 $ x
             ^ pose-disturbed: {why}
        r1 $ y || left_arm up
             ^ pose-disturbed: {why}
        r1 $ y || left_arm left
    """)


def test_joints_are_followed_from_line_to_line() -> None:
    most = "it turns to 119.5° at most: go less far"
    check(
        f"""
        r $ head repeat 5 left
                          ^^^^ joint-limit: at the end of beat 4, in round 4, yaw would be at 120°; {most}
        r $ head right head left
        r $ head left
                 ^^^^ joint-limit: at the end of beat 8, yaw would be at 149.5°; {most}
        """,
        robots=FAST,
        in_room=True,
    )


def test_a_velocity_that_a_joint_cannot_get_to_in_time_is_too_sudden() -> None:
    """A joint that gets there before the next velocity follows only lags."""
    needs = "yaw needs 1 s to get from 60°/s to -60°/s: use `beat 42`, or `slow 2 ( … )` around the whole movement"
    check(
        f"""
        r $ head [left right] rest
                       ^^^^^ too-sudden: this lasts 0.5 s, but {needs}
        r $ head (left right) rest
        """,
        robots=FAST.replace("max_velocity = 45", "max_acceleration = 120"),
        in_room=True,
    )


def test_a_smooth_joint_moves_gently() -> None:
    """Its part plays as with `ease`, as fast as it may: the second one would be too fast."""
    smooth = FAST.replace("max_velocity = 45", "max_velocity = 45\nsmooth = true")
    found = compiled(analyze("beat 60\nr $ head (left rest left fast 3/2 right)\n", read_robots(smooth)))
    plain = [round(math.degrees(speed), 6) for _, _, speed in found["robots"]["r"]["joints"]["yaw"]]
    assert plain == [10, 30, 40, 30, 10, 0, 10, 30, 40, 30, 10, -45]


def test_a_pose_that_is_too_far_for_one_beat_is_too_fast() -> None:
    check(
        """
        r $ head to far
                 ^^^^^^ too-fast: 100°/s is over the limit of yaw, 45°/s: use `beat 27`, or `slow 3 ( … )` around the whole movement
        r $ head slow 9/4 to start
        """,
        robots=FAST,
        in_room=True,
    )


@pytest.mark.parametrize(
    "movement", ["head (left to start)", "head reflect YZ (right to start)", "reflect YZ head (right to start)"]
)
def test_the_start_has_no_mirror_image(movement: str) -> None:
    """Check that a reflection that leaves a pose to its part mirrors the pose, but not the start."""
    robots = read_robots(FAST.replace("max = 119.5", "max = 119.5\nstart = 20"))
    turns = compiled(analyze(f"r $ {movement}", robots))["robots"]["r"]["joints"]["yaw"]
    assert turns == [[0, 1, pytest.approx(math.radians(30))], [1, 1, pytest.approx(math.radians(-30))]]


def test_programs_without_parts_and_those_with_errors_are_not_followed() -> None:
    robots = read_robots(FAST)
    assert check_joints(analyze("r $ forward", robots)) == ()
    assert check_joints(analyze("r $ head fast 9 left nonsense", robots)) == ()


def test_a_change_of_improv_toml_changes_the_meaning_of_words() -> None:
    text = "x = tail left\nr $ x\n"
    robots = read_robots(FAST.replace("body.head", "body.tail"))
    before = analyze(text)
    assert [each.code for each in before.diagnostics] == ["unknown-name"]
    after = before.with_robots(robots).settled()
    assert after.diagnostics == analyze(text, robots).diagnostics == ()
    assert [each.code for each in after.with_robots(read_robots("")).settled().diagnostics] == ["unknown-name"]


def test_senses_decide_for_the_base_and_for_body_parts_alike() -> None:
    """Check that a pose that `pause` interrupts continues with the velocity that it began with."""
    program = "ada is puppet\nada $ until cue head repeat left\nada $ pause near left_arm (to wide up) forward\n"
    senses = [{"sense": "cue", "from": 1.5, "to": 1.5}, {"sense": "near", "from": 2.5, "to": 3.2}]
    found = compiled(analyze(program), script=read_script(json.dumps(senses)))["robots"]["ada"]
    assert found["segments"] == [[0, 5, 0, 0, 0, 0], [5, 1, 1, 0, 0, 0]]
    turning, raising, rolling = (math.radians(each) for each in (30, 45, 80))
    assert found["joints"] == {
        "head_yaw": [[0, 1.5, pytest.approx(turning)], [1.5, 4.5, 0]],
        "left_shoulder_roll": [
            [0, 2, 0],
            [2, 0.5, pytest.approx(rolling)],
            [2.5, 1, 0],
            [3.5, 0.5, pytest.approx(rolling)],
            [4, 2, 0],
        ],
        "left_shoulder_pitch": [[0, 4, 0], [4, 1, pytest.approx(raising)], [5, 1, 0]],
    }
