"""Errors in the body of a profile, at their places."""

from __future__ import annotations

import math

import pytest

from improv_core.robots.config import read_robots
from improv_core.score.body import Body

HEAD = '[profiles.a]\nstep = 1\n[profiles.a.body.h]\nleft = { joint = "j", degrees = 30 }\n'
HOME = HEAD.replace("step = 1", 'step = 1\njoint_states = "/states"\nhome = "move"')
FAST = "[profiles.a.joints.j]\nmax_velocity = 9\n"
POSES, LIMITS, CONTROLLER = (HEAD + f"[profiles.a.{each}]\n" for each in ("body.h.poses", "joints.j", "controllers.c"))
ROBOT = HEAD + '[robots.r]\nprofile = "a"\n'
ARMS = (
    '[profiles.a]\nstep = 1\n[profiles.a.body.l]\nmirror = "r"\nleft = { joint = "lj", degrees = 30 }\n'
    '[profiles.a.body.r]\nleft = { joint = "rj", degrees = -30 }\n'
)


@pytest.mark.parametrize(
    ("text", "marked", "message"),
    [
        (HEAD + 'up = { joint = "j", degrees = 3 }', '"j"', "`left` of `h` already moves `j`: give each direction"),
        (HEAD.replace('"j"', '""'), '""', "write the name of a joint"),
        (HEAD.replace('"j"', '"a\\u001b[31m"'), '"a', "write the name of a joint"),
        (HEAD.replace("30", "nan"), "nan", "write `degrees` in degrees, from -720 to 720"),
        (HEAD.replace("30", "0"), "0", "write `degrees` as a number other than 0"),
        (
            HEAD.replace("degrees", "meters = 1, degrees"),
            "{ joint",
            "a joint and degrees, or meters",
        ),
        (HEAD.replace("body.h", "body.forward"), "forward", "`forward` is a word of the language"),
        (HEAD.replace("body.h", 'body."a b"'), '"a b"', "`a b` can't be the name of a body part"),
        (HEAD.replace("left = ", "lefd = "), "lefd", "did you mean `left`?"),
        ("[profiles.a]\nstep = 1\n[profiles.a.body.h]\n", "h", "`h` moves nothing: add a direction"),
        (HEAD + 'mirror = "k"', '"k"', "`k` is not another body part of this profile"),
        (
            ARMS + '[profiles.a.body.m]\nmirror = "r"\nup = { joint = "m", degrees = 1 }',
            '"r"',
            "has another mirror already",
        ),
        (HEAD + '[profiles.a.body.g]\nparts = ["h"]\n[profiles.a.body.gg]\nparts = ["g"]', '"g"', "not for groups"),
        (HEAD + "[profiles.a.body.g]\nparts = []", "[]", "write `parts` as a list, such as"),
        (HEAD + '[profiles.a.body.g]\nparts = ["h"]\nmirror = "h"', "mirror", "is a group of body parts"),
        (LIMITS + "min = 3\nmax = 1", "3", "`min` is greater than `max`: swap them"),
        (LIMITS + "max = nan", "nan", "write `max`"),
        (LIMITS + "max = 3\nstart = 4", "4", "`start` is beyond `min` or `max`"),
        (HEAD + "[profiles.a.joints.q]\nmax = 3", "q", "no direction moves `q`"),
        (
            ROBOT + "joints.q.offset = 3",
            "q",
            "its profile has no joint `q`: write one of `j`",
        ),
        (HEAD + "[robots.r]\njoints.j.offset = 3", "j", "its profile has no joint `j`: remove this"),
        (ROBOT + 'joints.j.offset = "3"', '"3"', "write `offset`"),
        (POSES + "start = { left = 3 }", "start", "`start` is a word of the language"),
        (POSES + "high = { up = 3 }", "up", "`h` has no direction `up`"),
        (
            POSES + "far = { left = 90 }\n[profiles.a.joints.j]\nmin = -3\nmax = 10",
            "90",
            "this is beyond the limits of `j`: from -3 to 10 degrees",
        ),
        (
            ARMS + "[profiles.a.body.l.poses]\nfar = { left = 90 }\n[profiles.a.joints.rj]\nmin = -3\nmax = 10",
            "far",
            "its mirror image is beyond the limits of `rj`: from -3 to 10 degrees",
        ),
        (CONTROLLER + 'joints = [""]', '""', "write the name of a joint"),
        (CONTROLLER + 'joints = ["x"]', "controllers", "no controller moves `j`: add it to the `joints` of one"),
        (HEAD + '[profiles.a.controllers.1c]\njoints = ["j"]', "1c", "`1c` can't be part of a topic"),
        (CONTROLLER, "c", "add the joints of `c`"),
        (
            CONTROLLER + 'joints = ["j"]\n[profiles.a.controllers.d]\njoints = ["j"]',
            '"j"',
            "`c` already moves `j`: remove one",
        ),
        (CONTROLLER + 'joints = ["j", "j"]', '"j"', "`j` is here twice: remove one"),
        (CONTROLLER + 'joints = ["j"]\ninterface = "effort"', '"effort"', "is not valid here"),
        (CONTROLLER + 'joints = ["j"]\ntopic = "a b"', '"a b"', "use the letters a to z"),
        (ARMS + '[profiles.a.controllers.c]\njoints = ["lj"]', "controllers", "no controller moves `rj`"),
        (HEAD.replace("step = 1", 'step = 1\nhome = "go"'), '"go"', "is not valid here"),
        (
            HEAD.replace("step = 1", 'step = 1\nhome = "move"'),
            "home",
            "Improv must know where they are: add `joint_states`",
        ),
        (HOME, "home", "at a fifth of their highest speed: add `max_velocity` of `j`"),
        (
            HOME + FAST + '[profiles.b]\nbase = "a"\n[profiles.b.body.k]\nup = { joint = "i", degrees = 3 }\n',
            "b",
            "add `max_velocity` of `i`",
        ),
        (
            HOME + FAST + '[profiles.a.controllers.c]\njoints = ["j"]\ninterface = "velocity"',
            "home",
            "a velocity controller can't move joints to their starts",
        ),
        ("[profiles.a]\nstep = 1\nbody = 3", "3", "write `body` as a section"),
    ],
)
def test_an_error_is_reported_once_at_its_place(text: str, marked: str, message: str) -> None:
    robots = read_robots(text)
    (found,) = robots.diagnostics
    assert text[found.span.start : found.span.end].startswith(marked)
    assert message in found.message
    assert "\n" not in found.message


def body_of(text: str, profile: str = "a") -> Body:
    robots = read_robots(text)
    assert robots.ok, robots.diagnostics
    body = robots.profiles[profile].body
    assert body
    return body


def test_a_body_is_inherited_and_its_parts_are_replaced() -> None:
    own = '[profiles.p.body.head]\nup = { joint = "neck", degrees = 10 }\n[profiles.p.joints.left_elbow]\nmax = 90\n'
    body = body_of(f'[profiles.p]\nbase = "puppet"\n{own}', "p")
    assert [each.name for each in body.parts] == ["left_arm", "right_arm", "head"]
    assert "head_yaw" not in body.joint
    assert body.joint["left_elbow"].max == pytest.approx(math.pi / 2)
    assert body.joint["left_elbow"].min == 0


def test_the_joints_of_one_robot_are_offset() -> None:
    robots = read_robots(f'{HEAD}[robots.r]\nprofile = "a"\njoints.j.offset = 90\n[robots.s]\nprofile = "a"')
    assert not robots.diagnostics
    bodies = [robots.robot(name).profile.body for name in ("r", "s")]
    assert [body and body.joint["j"].offset for body in bodies] == [pytest.approx(math.pi / 2), 0]


def test_a_puppet_of_your_own_replaces_the_built_in_one() -> None:
    robots = read_robots('[profiles.puppet]\nstep = 1\n[profiles.puppet.body.tail]\nup = { joint = "t", degrees = 9 }')
    assert robots.diagnostics == ()
    assert robots.part_words == {"tail"}


def test_pose_values_are_in_the_sense_of_their_direction() -> None:
    head = HEAD.replace("degrees = 30", "degrees = -20")
    body = body_of(head + "[profiles.a.body.h.poses]\naside = { left = 40 }")
    (pose,) = body.part["h"].poses
    assert pose.steps == {"yaw": pytest.approx(2)}


def test_joints_away_from_their_starts_are_waited_for_or_moved() -> None:
    """The dance waits for them, unless a profile or its base sets another value."""
    assert body_of(HEAD).home == "wait"
    assert body_of(HOME + FAST).home == "move"
    derived = f'{HOME}{FAST}[profiles.b]\nbase = "a"\n[profiles.b.body.k]\nup = {{ joint = "i", degrees = 3 }}\n'
    assert body_of(f"{derived}[profiles.b.joints.i]\nmax_velocity = 9\n", "b").home == "move"
    assert body_of(HOME.replace('"move"', '"wait"')).home == "wait"
