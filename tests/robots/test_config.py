"""Robots and their profiles in an `improv.toml`, with the errors drawn under it."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path

import pytest

from improv_core.robots.config import Robot, Robots, find_robots_file, read_robots
from improv_core.score.motion import Pose
from improv_core.score.profiles import BUILT_IN, DEFAULT, MOTIONS, TURTLEBOT3_BURGER, TURTLEBOT4, TURTLESIM, Profile
from improv_core.score.world import Circle, Wall, World
from tests.robots.drawing import check

DOCS = Path(__file__).parents[2] / "docs"
PAGE = "".join((DOCS / name).read_text(encoding="utf-8") for name in ("robots.md", "profiles.md", "ros.md", "music.md"))
FLEET = (DOCS / "fleet.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE + FLEET, re.DOTALL)


def test_a_robot_in_five_lines() -> None:
    found = check("""
        [robots.burger]
        profile = "turtlebot3_burger"
        topic = "/cmd_vel"
        message = "TwistStamped"
        start = { x = 0.5, y = -1, heading = 90 }
    """)
    assert found.robots == {
        "burger": Robot(TURTLEBOT3_BURGER, Pose(0.5, -1.0, heading=math.pi / 2), "/cmd_vel", "TwistStamped")
    }


def test_everything_about_a_robot_may_be_left_out() -> None:
    assert check("[robots.a]").robots == {"a": Robot(DEFAULT, None, "/a/cmd_vel", "auto")}


def test_a_robot_that_is_not_listed_may_do_anything() -> None:
    robot = Robots().robot("r")
    assert robot == Robot(DEFAULT, None, "/r/cmd_vel", "auto")
    assert (robot.profile.step, robot.profile.motions, robot.profile.max_linear) == (TURTLESIM.step, MOTIONS, None)


def test_a_profile_inherits_from_its_base() -> None:
    found = check("""
        [robots.a]
        profile = "slow"

        [profiles.slow]
        base = "lab"
        max_linear = 0.1
        message = "Twist"

        [profiles.lab]
        base = "turtlebot4"
        quarter_turn = 92.5
        motions = ["turn", "forward", "turn"]
    """)
    profile = found.robots["a"].profile
    assert profile is found.profiles["slow"]
    assert profile.name == "slow"
    assert (profile.step, profile.max_linear, profile.max_angular) == (TURTLEBOT4.step, 0.1, 1.9)
    assert (profile.quarter_turn, profile.motions) == (math.radians(92.5), ("forward", "turn"))
    assert found.robots["a"].message == profile.message == "Twist"


def test_robots_that_follow_need_odometry() -> None:
    found = check("""
        [robots.anna]
        profile = "turtlebot4"
        odom = "pose"
        follow = true

        [robots.bert]
        profile = "turtlebot4"
        follow = true
        ^^^^^^ robots: `follow` needs to know where the robot is: add `odom`

        [robots.cleo]
        odom = "pose"
        follow = true
        ^^^^^^ robots: `follow` works only with `motions = ["forward", "turn"]` in the profile

        [robots.emil]
        profile = "worn"
        follow = true

        [profiles.worn]
        base = "turtlebot4"
        dynamics = "motors"
    """)
    assert [name for name, robot in found.robots.items() if robot.follow] == ["anna", "bert", "cleo", "emil"]


def test_a_profile_without_a_base_says_its_step_and_is_not_limited_in_the_rest() -> None:
    assert check("[profiles.mine]\nstep = 1").profiles["mine"] == Profile("mine", step=1.0)
    check("""
        [profiles.mine]
                  ^^^^ robots: add `step`, in meters, or `base`, the profile to take all other values from
        max_linear = 1
    """)


def test_each_kind_of_wrong_value_has_its_advice() -> None:
    """tests/robots/test_schema.py tries all keys."""
    found = check("""
        ros = 3
              ^ robots: write `ros` as a section: `[ros]`
        [robots]
        a = "turtlesim"
            ^^^^^^^^^^^ robots: write `a` as a section: `[robots.a]`
        [robots.b]
        topic = ["/a"]  # one is enough
                ^^^^^^ robots: write `topic` as text, in quotes
        message = "String"
                  ^^^^^^^^ robots: `String` is not valid here: write one of `auto`, `Twist`, `TwistStamped`
        start = [1, 2]
                ^^^^^^ robots: write `start` as a table, such as `{ x = 0, y = 0, heading = 0 }`
        namespac = "b"
        ^^^^^^^^ robots: `namespac` is not valid here: did you mean `namespace`?
        [robots.c]
        start = { x = nan, heading = 1979-05-27 07:32:00 }
                      ^^^ robots: write `x` in meters, from -1000 to 1000
                                     ^^^^^^^^^^^^^^^^^^^ robots: write `heading` in degrees, from -360 to 360
        [hosts.pi]
        domain = 300
                 ^^^ robots: write `domain` as a whole number from 0 to 232
        [profiles.a]
        step = 0
               ^ robots: write `step` in meters, from 0.001 to 100
        smooth = "yes"
                 ^^^^^ robots: write `smooth` as `true` or `false`
        dynamics = "motors"
        wheel_error = [0, true]
                       ^ robots: write this as a number from 0.5 to 1.5
                          ^^^^ robots: write this as a number from 0.5 to 1.5
        motions = [
            "turn",
            "fly",  # no such thing
            ^^^^^ robots: `fly` is not valid here: write one of `forward`, `turn`, `strafe`, `climb`
        ]
        [profiles.b]
        step = 1
        motions = []
                  ^^ robots: write `motions` as a list, such as `["forward", "turn"]`
        [world]
        size = [6]
               ^^^ robots: write `size` as 2 numbers in meters, such as `[6, 4]`
        walls = [[0, 0, 1], [0, 0, 1, 1]]
                 ^^^^^^^^^ robots: write this as a wall: 4 numbers in meters, from x, y to x, y, such as `[0, 0, 2, 0]`
        circles = [{ x = 1 }, 3, { radius = 0.3, tint = 1 }]
                   ^^^^^^^^^ robots: add `radius`, in meters
                              ^ robots: write this as a round obstacle, such as `{ x = 1, y = 0, radius = 0.3 }`
                                                 ^^^^ robots: `tint` is not valid here: write one of `x`, `y`, `radius`
    """)
    assert found.profiles["a"] == Profile("a", step=DEFAULT.step, dynamics="motors", motions=("turn",))
    assert found.profiles["b"].motions == MOTIONS
    assert found.world == World(walls=(Wall(0, 0, 1, 1),), circles=(Circle(0, 0, 0.3),))


def test_noise_is_of_motors() -> None:
    check("""
        [profiles.c]
        base = "turtlebot4"
        noise = 0.01
        ^^^^^ robots: `noise` works only with `dynamics = "motors"`: add that line
    """)


def test_an_unknown_profile_is_marked_and_limits_nothing() -> None:
    found = check("""
        [profiles.lab_burger]
        base = "turtlebot3_burgr"
               ^^^^^^^^^^^^^^^^^^ robots: `turtlebot3_burgr` is not valid here: did you mean `turtlebot3_burger`?
        [robots.a]
        profile = 'Lab_Burger'
                  ^^^^^^^^^^^^ robots: `Lab_Burger` is not valid here: did you mean `lab_burger`?
    """)
    assert found.robots["a"].profile == DEFAULT, "one mistake is one message: nothing limits it now"


def test_profiles_based_on_each_other_are_marked() -> None:
    found = check("""
        [profiles.self]
        base = "self"
               ^^^^^^ robots: with base `self`, `self` is based on itself: choose another base
        [profiles.a]
        base = "b"
        [profiles.b]
        base = "c"
        [profiles.c]
        base = "b"
               ^^^ robots: with base `b`, `c` is based on itself: choose another base
    """)
    assert set(found.profiles) == {*BUILT_IN, "self", "a", "b", "c"}


def test_a_long_chain_of_profiles_is_read() -> None:
    links = [f'[profiles.p{place}]\nbase = "p{place + 1}"' for place in range(3000)]
    found = read_robots("\n".join([*links, "[profiles.p3000]\nstep = 3"]))
    assert found.diagnostics == ()
    assert found.profiles["p0"].step == 3


def test_built_in_profiles_stay_what_they_are() -> None:
    found = check("""
        [profiles.turtlesim]
                  ^^^^^^^^^ robots: `turtlesim` is built in: choose another name and use it as `base`
        step = 1
    """)
    assert found.profiles["turtlesim"] is TURTLESIM


def test_the_file_is_found_above_the_program_and_not_above_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "other").mkdir()
    (tmp_path / "here" / "improv.toml").write_text("")
    monkeypatch.chdir(tmp_path / "here")
    assert find_robots_file(Path("../other")) is None
    assert find_robots_file(Path("../here")) == tmp_path / "here" / "improv.toml"
    (tmp_path / "improv.toml").write_text("")
    assert find_robots_file(Path("../other")) == tmp_path / "improv.toml"


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_link_counts_in_its_folder_and_dots_after_it_lead_above_its_target(tmp_path: Path) -> None:
    (tmp_path / "show").mkdir()
    (tmp_path / "lab" / "dances").mkdir(parents=True)
    (tmp_path / "show" / "tonight").symlink_to(tmp_path / "lab" / "dances")
    for folder in ("show", "lab"):
        (tmp_path / folder / "improv.toml").write_text("")
    assert find_robots_file(tmp_path / "show" / "tonight") == tmp_path / "show" / "improv.toml"
    assert find_robots_file(tmp_path / "show" / "tonight" / "..") == tmp_path / "lab" / "improv.toml"


def test_the_examples_in_the_docs_are_right() -> None:
    assert {block: found for block in BLOCKS if (found := read_robots(block).diagnostics)} == {}


def test_the_page_has_the_built_in_numbers() -> None:
    for profile in BUILT_IN.values():
        (row,) = re.findall(rf"^\| `{profile.name}`.*$", PAGE, re.MULTILINE)
        limits = (profile.max_linear, profile.max_angular, profile.max_linear_acceleration)
        for number in (profile.step, profile.radius, profile.max_angular_acceleration, *limits):
            assert number is None or f"{number:g} " in row
        assert (", ".join(profile.motions) if profile.motions != MOTIONS else "all four") in row
