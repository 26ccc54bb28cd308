"""What an `improv.toml` says, and what is drawn under it where it is wrong."""

from __future__ import annotations

import json
import math
import os
import re
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.robots.config import Robot, Robots, find_robots_file, read_robots
from improv_core.score.body import from_json as body_from_json
from improv_core.score.motion import Pose
from improv_core.score.profiles import BUILT_IN, DEFAULT, MOTIONS, TURTLEBOT3_BURGER, TURTLEBOT4, TURTLESIM, Profile
from improv_core.score.score import Deadman, Safety, Score
from improv_core.score.score_json import from_json, to_json
from improv_core.score.senses import Topic
from improv_core.score.world import Box, Circle, Wall, World
from improv_core.text import LineIndex
from tests.program.drawing import carets, undrawn
from tests.strange_files import StrangeFile

DOCS = Path(__file__).parents[2] / "docs"
PAGE = "".join((DOCS / name).read_text(encoding="utf-8") for name in ("robots.md", "profiles.md", "ros.md", "music.md"))
FLEET = (DOCS / "fleet.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE + FLEET, re.DOTALL)


def check(expected: str) -> Robots:
    """Read the lines without carets; the diagnostics drawn under them must be the lines with carets."""
    expected, text = undrawn(expected)
    found = read_robots(text)
    assert carets(LineIndex(text), found.diagnostics) == expected
    assert found.ok == (not found.diagnostics)
    return found


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


def test_robots_that_follow() -> None:
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

        [robots.dora]
        odom = "pose"
        follow = 1
                 ^ robots: write `follow` as `true` or `false`

        [robots.emil]
        profile = "worn"
        follow = true

        [profiles.worn]
        base = "turtlebot4"
        dynamics = "motors"
    """)
    assert [name for name, robot in found.robots.items() if robot.follow] == ["anna", "bert", "cleo", "emil"]


def test_commanded_steps_scale_with_the_step() -> None:
    found = check("""
        [profiles.lab]
        base = "turtlebot4"
        commanded_step = 0.21
        commanded_quarter_turn = 99

        [profiles.long]
        base = "lab"
        step = 0.4

        [profiles.slip]
        step = 0.2
        commanded_step = 2.1
                         ^^^ robots: this is far from `step`: write from 0.5 to 2 times as much
    """)
    for name, step in (("lab", 0.2), ("long", 0.4)):
        profile = found.profiles[name]
        assert (profile.step, profile.quarter_turn) == (step, math.pi / 2)
        assert (profile.linear_scale, profile.angular_scale) == pytest.approx((1.05, 1.1))


def test_a_profile_without_a_base_says_its_step_and_is_not_limited_in_the_rest() -> None:
    assert check("[profiles.mine]\nstep = 1").profiles["mine"] == Profile("mine", step=1.0)
    check("""
        [profiles.mine]
                  ^^^^ robots: add `step`, in meters, or `base`, the profile to take all other values from
        max_linear = 1
    """)


def test_a_name_for_the_node() -> None:
    assert check('[ros]\nnode = "conductor_1"').node == "conductor_1"
    assert check("").node is None
    found = check("""
        [ros]
        node = "/lab/conductor"
               ^^^^^^^^^^^^^^^^ robots: use the letters a to z, digits, and `_`, not starting with a digit, without `/`
    """)
    assert found.node is None


def test_robots_that_drift() -> None:
    found = check("""
        [profiles.worn]
        base = "turtlebot4"
        dynamics = "motors"
        wheel_error = [0.96, 0.94]
        noise = 0.01

        [profiles.new]
        base = "worn"
        noise = 0
    """)
    worn, new = found.profiles["worn"], found.profiles["new"]
    assert (worn.wheel_error, worn.noise) == ((0.96, 0.94), 0.01)
    assert (new.wheel_error, new.noise) == ((0.96, 0.94), 0)


def test_drift_that_makes_no_sense() -> None:
    found = check("""
        [profiles.a]
        base = "turtlebot4"
        dynamics = "motors"
        wheel_error = [0.96]
                      ^^^^^^ robots: write `wheel_error` as two numbers from 0.5 to 1.5, left and right: `[0.98, 1.0]`
        noise = 1
                ^ robots: write `noise` in shares of the speed, from 0 to 0.5

        [profiles.b]
        base = "a"
        wheel_error = [0, true]
                      ^^^^^^^^^ robots: write `wheel_error` as two numbers from 0.5 to 1.5, left and right: `[0.98, 1.0]`

        [profiles.c]
        base = "turtlebot4"
        noise = 0.01
        ^^^^^ robots: `noise` works only with `dynamics = "motors"`: add that line
    """)
    assert found.profiles["b"].wheel_error == (1.0, 1.0)


def test_a_world() -> None:
    found = check("""
        [world]
        size = [6, 4]
        walls = [[-1, 0, 1, 0.5]]
        circles = [{ x = 1, radius = 0.3 }]
        [[world.boxes]]
        width = 1
        height = 0.5
        heading = 90
    """)
    assert found.world == World(
        (6, 4), (Wall(-1, 0, 1, 0.5),), (Circle(1, 0, 0.3),), (Box(0, 0, 1, 0.5, heading=math.pi / 2),)
    )


def test_wrong_parts_of_a_world_are_left_out() -> None:
    found = check("""
        [world]
        size = [6, 0]
                   ^ robots: write this in meters, from 0.001 to 1000
        walls = [[0, 0, 1], [0, 0, 1, 1]]
                 ^^^^^^^^^ robots: write 4 numbers in meters, such as [0, 0, 2, 0]: from x, y to x, y
        circles = [{ x = 1 }, 3, { radius = 0.3, tint = 1 }]
                   ^^^^^^^^^ robots: add `radius`, in meters
                              ^ robots: write it in meters: `{ x = 1, y = 0, radius = 0.3 }`
                                                 ^^^^ robots: `tint` is not valid here: write one of `x`, `y`, `radius`
        boxes = { width = 1, height = "2" }
                ^^^^^^^^^^^^^^^^^^^^^^^^^^^ robots: write `boxes` as a list, in `[` and `]`
        lake = 1
        ^^^^ robots: `lake` is not valid here: write one of `size`, `walls`, `circles`, `boxes`, `margin`, `keep_apart`
    """)
    assert found.world == World(walls=(Wall(0, 0, 1, 1),), circles=(Circle(0, 0, 0.3),))


def test_robots_start_inside_the_walls() -> None:
    check("""
        [world]
        size = [6, 4]
        [robots.a]
        start = { x = 3, y = 2 }
        [robots.b]
        start = { x = 3.5 }
                ^^^^^^^^^^^ robots: this start is outside the walls: move it inside
    """)


def test_a_robot_that_is_wider_than_the_floor() -> None:
    check("""
        [world]
        size = [6, 0.5]
        [robots.a]
                ^ robots: `a` is 0.6 m wide and doesn't fit: make the world larger
        [robots.b]
        profile = "quadrotor"
    """)


def test_unknown_keys() -> None:
    check("""
        robts = 1
        ^^^^^ robots: `robts` is not valid here: did you mean `robots`?
        [robots.a]
        Profile = "turtlesim"
        ^^^^^^^ robots: `Profile` is not valid here: did you mean `profile`?
        start = { x = 1, z = 2 }
                         ^ robots: `z` is not valid here: write one of `x`, `y`, `heading`
        [profiles.b]
        step = 1
        "max linear" = 1
        ^^^^^^^^^^^^ robots: `max linear` is not valid here: did you mean `max_linear`?
        command = "/bin/sh"
        ^^^^^^^ robots: `command` is not valid here: did you mean `command_rate`?
    """)


def test_wrong_types() -> None:
    check("""
        world = 3
                ^ robots: write `world` as a section: `[world]`
        [robots]
        a = "turtlesim"
            ^^^^^^^^^^^ robots: write `a` as a section: `[robots.a]`
        [robots.b]
        profile = 3
                  ^ robots: write `profile` as text, in quotes
        topic = ["/a"]  # one is enough
                ^^^^^^ robots: write `topic` as text, in quotes
        start = [1, 2]
                ^^^^^^ robots: write `start` in meters and degrees: `{ x = 1.5, y = 0, heading = 90 }`
        [[profiles]]
          ^^^^^^^^ robots: write `profiles` as a section: `[profiles]`
    """)


def test_numbers_out_of_range() -> None:
    found = check("""
        [profiles.a]
        step = 0
               ^ robots: write `step` in meters, from 0.001 to 100
        quarter_turn = 1.57
                       ^^^^ robots: write `quarter_turn` in degrees, from 45 to 135
        max_linear = -0.2
                     ^^^^ robots: write `max_linear` in m/s, from 0.001 to 100
        max_angular = inf
                      ^^^ robots: write `max_angular` in rad/s, from 0.001 to 100
        command_rate = true
                       ^^^^ robots: write `command_rate` in Hz, from 1 to 200
        radius = "0.3"
                 ^^^^^ robots: write `radius` in meters, from 0.001 to 100
        [robots]
        b = { start = { x = nan, heading = 1979-05-27 07:32:00 } }
                            ^^^ robots: write `x` in meters, from -1000 to 1000
                                           ^^^^^^^^^^^^^^^^^^^ robots: write `heading` in degrees, from -360 to 360
    """)
    assert found.profiles["a"] == Profile("a", step=DEFAULT.step)


def test_unknown_profiles_and_messages() -> None:
    found = check("""
        [profiles.lab_burger]
        base = "turtlebot3_burgr"
               ^^^^^^^^^^^^^^^^^^ robots: `turtlebot3_burgr` is not valid here: did you mean `turtlebot3_burger`?
        [robots.a]
        profile = 'Lab_Burger'
                  ^^^^^^^^^^^^ robots: `Lab_Burger` is not valid here: did you mean `lab_burger`?
        message = "String"
                  ^^^^^^^^ robots: `String` is not valid here: write one of `auto`, `Twist`, `TwistStamped`
    """)
    assert found.robots["a"].profile == DEFAULT, "one mistake is one message: nothing limits it now"


def test_profiles_in_a_circle() -> None:
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


def test_a_long_chain_of_profiles() -> None:
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


def test_motions() -> None:
    found = check("""
        [profiles.a]
        step = 1
        motions = [
            "turn",
            "fly",  # no such thing
            ^^^^^ robots: write one of `forward`, `turn`, `strafe`, `climb` here
            3,
            ^ robots: write one of `forward`, `turn`, `strafe`, `climb` here
        ]
        [profiles.b]
        step = 1
        motions = []
                  ^^ robots: write `motions` as a list of one or more of `forward`, `turn`, `strafe`, `climb`
    """)
    assert found.profiles["a"].motions == ("turn",)
    assert found.profiles["b"].motions == MOTIONS


def test_names_that_robots_cannot_have() -> None:
    found = check("""
        [robots.forward]
                ^^^^^^^ robots: `forward` is a reserved word: choose another name
        [robots."a b"]
                ^^^^^ robots: `a b` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        [robots._a]
                ^^ robots: `_a` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        [robots.9]
                ^ robots: `9` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        step = 1
        ^^^^ robots: `step` is not valid here: write one of `profile`, `start`, `namespace`, `topic`, `message`, `frame`, `reset`, `odom`, `odom_frame`, `battery`, `joints`, `host`, `link_patience`, `follow`
    """)
    assert found.robots == {}


def test_topics_that_ros_takes_and_those_that_it_refuses() -> None:
    for topic in ("/cmd_vel", "/a/_b/c1", "/a__b", "/A_", "/" + "a" * 246):
        assert read_robots(f'[robots.a]\ntopic = "{topic}"').robots["a"].topic == topic
    for topic in ("/", "", "/a/", "//a", "/1a", "/a/2", "/a-b", "/a b", "/é", "/~", "/{a}", "/a\\n"):
        found = read_robots(f'[robots.a]\ntopic = "{topic}"')
        assert [diagnostic.span for diagnostic in found.diagnostics] == [(19, 21 + len(topic))]
        assert found.robots["a"].topic == "/a/cmd_vel"


def test_names_of_ros_are_not_too_long() -> None:
    check("""
        [robots.b]
        topic = "/b/cmd-vel"
                ^^^^^^^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
        reset = "2nd"
                ^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
        odom = "a b"
               ^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
    """)
    (diagnostic,) = read_robots(f'[robots.a]\ntopic = "/{"a" * 247}"').diagnostics
    assert diagnostic.message == "this name is too long for ROS 2: use at most 247 characters"


def test_a_namespace_is_before_all_names_that_do_not_begin_with_a_slash() -> None:
    found = check("""
        [ros]
        namespace = "lab/east"
        use_sim_time = true
        publish = true
        [robots.a]
        topic = "a/nav_vel"
        reset = "reset"
        frame = "a/base_footprint"
        odom = "odom"
        [robots.b]
        topic = "/cmd_vel"
        reset = "/reset"
        odom = "/odom"
        [robots.c]
    """)
    assert [robot.frame for robot in found.robots.values()] == ["a/base_footprint", "base_link", "base_link"]
    names = [(robot.topic, robot.reset, robot.odom) for robot in found.robots.values()]
    assert names == [
        ("/lab/east/a/nav_vel", "/lab/east/reset", "/lab/east/a/odom"),
        ("/cmd_vel", "/reset", "/odom"),
        ("/lab/east/c/cmd_vel", None, None),
    ]
    assert found.robot("unlisted").topic == "/lab/east/unlisted/cmd_vel"
    assert found.use_sim_time
    assert found.publish


def test_the_frame_of_poses_is_set_for_all_robots_or_for_one() -> None:
    found = check("""
        [ros]
        odom_frame = "world"
        [robots.ada]
        odom = "pose"
        [robots.ben]
        odom = "odom"
        odom_frame = "own"
        [robots.cleo]
    """)
    assert {name: robot.odom_frame for name, robot in found.robots.items()} == {
        "ada": "world",
        "ben": "own",
        "cleo": "world",
    }
    found = check("""
        [ros]
        odom_frame = "map"
                     ^^^^^ robots: `map` is not valid here: write one of `own`, `world`
        [robots.ada]
        odom = "pose"
        [robots.ben]
        odom_frame = "world"
        ^^^^^^^^^^ robots: `odom_frame` is about the poses on `odom`: add `odom`
    """)
    assert found.robots["ada"].odom_frame == "own"


def test_stop_and_deadman_settings() -> None:
    found = check("""
        [ros]
        namespace = "lab"
        stop = "e_stop"
        deadman = { topic = "/joy", button = 4 }
        rejoin = "next"
    """)
    assert found.safety == Safety("/lab/e_stop", Deadman("/joy", 4), "next")
    data = json.loads(json.dumps(to_json(Score(Fraction(60), {}, safety=found.safety))))
    assert from_json(data).safety == found.safety
    assert from_json(to_json(Score(Fraction(60), {}))).safety == check("").safety == Safety()


def test_mistakes_in_the_stop_and_deadman_settings() -> None:
    check("""
        [ros]
        stop = "e-stop"
               ^^^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
        deadman = 4
                  ^ robots: write `deadman` as a topic and a button: `{ topic = "/joy", button = 4 }`
        rejoin = "contnue"
                 ^^^^^^^^^ robots: `contnue` is not valid here: did you mean `continue`?
    """)
    check("""
        [ros]
        deadman = { topic = "/joy" }
                  ^^^^^^^^^^^^^^^^^^ robots: write `deadman` as a topic and a button: `{ topic = "/joy", button = 4 }`
    """)
    check("""
        [ros]
        deadman = { topic = "joy/", button = -1 }
                            ^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
                                             ^^ robots: write `button` as a whole number from 0 to 99
    """)
    check("""
        [ros]
        stop = "joy"
               ^^^^^ robots: the deadman button is on this topic: the emergency stop needs one of its own
        deadman = { topic = "/joy", button = 4 }
    """)
    check("""
        [ros.deadman]
        topic = "/joy"
        button = 1.0
                 ^^^ robots: write `button` as a whole number from 0 to 99
    """)


def test_robots_drive_back_only_if_they_are_seen_and_keep_apart() -> None:
    found = check("""
        [ros]
        rejoin = "return"
        odom_frame = "world"
        [world]
        keep_apart = 0.3
        [robots.a]
        profile = "turtlebot4"
        odom = "pose"
    """)
    assert found.safety.rejoin == "return"
    check("""
        [ros]
        rejoin = "return"
                 ^^^^^^^^ robots: `return` has robots drive by themselves: add `keep_apart` under [world], so that they keep apart
    """)
    check("""
        [ros]
        rejoin = "return"
                 ^^^^^^^^ robots: `return` needs poses of robots in the world: list the robots under [robots]
        [world]
        keep_apart = 0.3
    """)
    check("""
        [ros]
        rejoin = "return"
                 ^^^^^^^^ robots: `return` needs poses of `b` in the world: add `odom` and `odom_frame = "world"`
        [world]
        keep_apart = 0.3
        [robots.a]
        odom = "pose"
        odom_frame = "world"
        [robots.b]
        odom = "odom"
    """)
    check("""
        [ros]
        rejoin = "return"
                 ^^^^^^^^ robots: `return` needs robots that turn on the spot and drive forward, which `a` can't
        odom_frame = "world"
        [world]
        keep_apart = 0.3
        [profiles.car]
        base = "turtlebot4"
        turning_radius = 0.5
        [robots.a]
        profile = "car"
        odom = "pose"
    """)


def test_without_a_namespace_names_begin_at_the_root() -> None:
    found = check("""
        [robots.a]
        topic = "cmd_vel"
    """)
    assert found.robots["a"].topic == "/cmd_vel"
    assert not found.use_sim_time
    assert check('[ros]\nnamespace = "/lab"').robot("a").topic == "/lab/a/cmd_vel"


def test_wrong_keys_and_values_of_ros() -> None:
    found = check("""
        [ros]
        namespace = "lab/"
                    ^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
        use_sim_time = "yes"
                       ^^^^^ robots: write `use_sim_time` as `true` or `false`
        publish = 1
                  ^ robots: write `publish` as `true` or `false`
        qos = 3
        ^^^ robots: `qos` is not valid here: write one of `namespace`, `node`, `publish`, `use_sim_time`, `odom_frame`, `stop`, `deadman`, `rejoin`, `start_without`
        [robots.a]
        reset = ["/reset"]
                ^^^^^^^^^^ robots: write `reset` as text, in quotes
        frame = "/base_link"
                ^^^^^^^^^^^^ robots: use the letters a to z, digits, `_`, `.`, `-`, and `/`, but no `/` at the start
    """)
    assert found.robots["a"] == Robot(DEFAULT, None, "/a/cmd_vel", "auto")
    check("""
        ros = true
              ^^^^ robots: write `ros` as a section: `[ros]`
    """)


@pytest.mark.parametrize(
    "drawn",
    [
        """
        [robots.a]
        profile = turtlesim
                  ^^^^^^^^^ syntax: write a value: a number, "text", [a list] or { a table }
        """,
        """
        [robots.a]
        profile = "turtlesim
                            ^ syntax: close the string with the same quote it starts with
        topic = "/a"
        """,
        """
        [profiles.a]
        step = 0.2m
                  ^ syntax: remove this or start a new line with it
        """,
        """
        [profiles.a]
        step 0.2
             ^^^ syntax: write `=` and a value after the key
        """,
        """
        [profiles.a]
        step = 0.2
        step = 0.3
        ^^^^^^^^^^ syntax: this key already has a value: remove one of them
        """,
        """
        [robots.a]
        [robots.a]
        ^^^^^^^^^^ syntax: this section already exists above: merge the two
        """,
        """
        [robots.a]
        start = { x = 1, x = 2 }
                         ^^^^^ syntax: this key already has a value: remove one of them
        """,
        """
        [robots.a]
        start = { x = 1, y = 2, }
                                ^ syntax: write a key here, or remove the comma before it
        """,
        """
        [robots.a]
        start = { x = 1
                       ^ syntax: close the table with `}`, on the line where it starts
        }
        """,
        """
        [robots.a]
        topic = "\\cmd_vel"
                 ^^ syntax: write `\\\\` for one backslash
        """,
        """
        [robots.a
                 ^ syntax: close the section name with `]`
        """,
        """
        [profiles.a]
        motions = ["turn"
                         ^ syntax: close the list with `]`
        # nothing follows
        """.replace("# nothing follows", ""),
        """
        !
        ^ syntax: write `key = value` or `[section]`
        """,
    ],
)
def test_syntax_errors(drawn: str) -> None:
    assert check(drawn).robots == {}


@pytest.mark.parametrize(
    "drawn",
    [
        """
        [robots.a]
        profile = turtlesim
                  ^^^^^^^^^ syntax: write a value: a number, "text", [a list] or { a table }
        topik = "/a"
        ^^^^^ robots: `topik` is not valid here: did you mean `topic`?
        [world]
        size = [6]
               ^^^ robots: write 2 numbers in meters, such as [6, 4]
        walls = [[0, 0, 1, 1]
                             ^ syntax: close the list with `]`
        circles = 3
                  ^ robots: write `circles` as a list, in `[` and `]`
        """,
        """
        robts = 1
        ^^^^^ robots: `robts` is not valid here: did you mean `robots`?
        [robots.a] x
                   ^ syntax: remove this or start a new line with it
        topik = "below a wrong header, nobody knows what it is for"
        y
         ^ syntax: write `=` and a value after the key
        [robots.b]
        profile = "husk"
                  ^^^^^^ robots: `husk` is not valid here: did you mean `husky`?
        """,
        """
        [robots.a]
        profile = "husky"
        profile = "jackal"
        ^^^^^^^^^^^^^^^^^^ syntax: this key already has a value: remove one of them
        [robots.a] # twice
        ^^^^^^^^^^ syntax: this section already exists above: merge the two
        start = { x = "1" }
                      ^^^ robots: write `x` in meters, from -1000 to 1000
        [ros]
        node = '''
        [robots.a]
        topic = 1
        ''' x
            ^ syntax: remove this or start a new line with it
        """,
        """
        [[world.circles]]
        x = 1
        y = 0
        radius =
                ^ syntax: write a value: a number, "text", [a list] or { a table }
        [[world.circles]]
        x = "1"
            ^^^ robots: write `x` in meters, from -1000 to 1000
        y = 0
        radius = 1
        """,
    ],
)
def test_a_syntax_error_hides_no_other_error(drawn: str) -> None:
    assert check(drawn).robots == {}


@pytest.mark.parametrize(
    "drawn",
    [
        """
        [profiles.rover]
        step = 0.2m
                  ^ syntax: remove this or start a new line with it
        commanded_step = 9
        noise = 0.1
        [robots.a]
        profile = "rovr"
        follow = true
        [formation]
        shape = line
                ^^^^ syntax: write a value: a number, "text", [a list] or { a table }
        """,
        """
        [senses.wet]
        topic = "wet"
        message =
                 ^ syntax: write a value: a number, "text", [a list] or { a table }
        [profiles.rover
                       ^ syntax: close the section name with `]`
        step = 0.2
        [robots.a]
        profile = "rover"
        """,
    ],
)
def test_a_broken_table_causes_no_follow_up_errors(drawn: str) -> None:
    assert check(drawn).robots == {}


def test_line_ends_of_other_systems_move_nothing() -> None:
    text = "\ufeff# 🐢\r\n[robots.a]\r\ntopic = 1\r\nstart = {\r\n"
    number, bracket = read_robots(text).diagnostics
    assert (number.code, number.span) == ("robots", (text.index("1"), text.index("1") + 1))
    assert (bracket.code, bracket.span) == ("syntax", (text.index("{") + 1,) * 2)
    (diagnostic,) = read_robots(text[: text.index("start")]).diagnostics
    assert (diagnostic.code, diagnostic.span) == ("robots", (text.index("1"), text.index("1") + 1))


NAMES = (
    "robots profiles world ros namespace use_sim_time reset a b base step motions start x topic senses message below"
)
keys = st.sampled_from([*NAMES.split(), "from", "timeout", "key", ""])
VALUES = r'1 1e999 -0 nan true "a" "turtlesim" "/a" "sensor_msgs/LaserScan" 07:32:00 "\n"'
anything = st.recursive(
    st.sampled_from(VALUES.split()),
    lambda inner: (
        st.lists(inner, max_size=2).map(lambda items: f"[{','.join(items)}]")
        | st.dictionaries(keys, inner, max_size=3).map(
            lambda table: "{" + ",".join(f'"{key}"={value}' for key, value in table.items()) + "}"
        )
    ),
)


@given(st.dictionaries(keys, anything, max_size=4), st.text(max_size=3))
def test_no_text_raises(table: dict[str, str], end: str) -> None:
    text = "\n".join(f'"{key}" = {value}' for key, value in table.items()) + end
    found = read_robots(text)
    for diagnostic in found.diagnostics:
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(text)
        assert len(diagnostic.message.splitlines()) == 1


def test_profiles_survive_json() -> None:
    for profile in BUILT_IN.values():
        data: dict[str, Any] = json.loads(json.dumps(asdict(profile)))
        data["body"] = body_from_json(data["body"])
        assert Profile(**data) == profile
        assert hash(Profile(**data)) == hash(profile)


def test_the_nearest_file_is_found(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    (tmp_path / "improv.toml").touch()
    assert find_robots_file(folder) == tmp_path / "improv.toml"
    (tmp_path / "a" / "improv.toml").touch()
    assert find_robots_file(folder) == tmp_path / "a" / "improv.toml"
    assert find_robots_file(folder / "not" / "there") == tmp_path / "a" / "improv.toml"


def test_the_file_is_looked_for_above_the_program_and_not_above_where_one_stands(
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
def test_a_link_counts_where_it_stands_and_dots_after_it_lead_above_its_target(tmp_path: Path) -> None:
    (tmp_path / "show").mkdir()
    (tmp_path / "lab" / "dances").mkdir(parents=True)
    (tmp_path / "show" / "tonight").symlink_to(tmp_path / "lab" / "dances")
    for folder in ("show", "lab"):
        (tmp_path / folder / "improv.toml").write_text("")
    assert find_robots_file(tmp_path / "show" / "tonight") == tmp_path / "show" / "improv.toml"
    assert find_robots_file(tmp_path / "show" / "tonight" / "..") == tmp_path / "lab" / "improv.toml"


def test_whatever_has_the_name_is_found(strange_file: StrangeFile) -> None:
    path = strange_file.make("improv.toml")
    assert find_robots_file(path.parent) == path


def test_the_examples_in_the_docs_are_right() -> None:
    assert {block: found for block in BLOCKS if (found := read_robots(block).diagnostics)} == {}


def test_the_page_has_the_built_in_numbers() -> None:
    for profile in BUILT_IN.values():
        (row,) = re.findall(rf"^\| `{profile.name}`.*$", PAGE, re.MULTILINE)
        limits = (profile.max_linear, profile.max_angular, profile.max_linear_acceleration)
        for number in (profile.step, profile.radius, profile.max_angular_acceleration, *limits):
            assert number is None or f"{number:g} " in row
        assert (", ".join(profile.motions) if profile.motions != MOTIONS else "all four") in row


def test_a_role_is_danced_by_the_robot_of_its_namespace() -> None:
    robots = check("""
        [ros]
        namespace = "lab"
        [robots.ada]
        namespace = "/tb3_07"
        odom = "odom"
        [robots.bo]
        namespace = "tb3_08"
        topic = "nav_vel"
        [robots.cleo]
        [senses.wall]
        topic = "scan"
        message = "sensor_msgs/LaserScan"
        below = 0.5
    """)
    names = {
        name: (robots.robot(name).topic, robots.robot(name).odom, robots.sense(name, "wall"))
        for name in ("ada", "bo", "cleo", "dan")
    }
    assert names == {
        "ada": ("/tb3_07/cmd_vel", "/tb3_07/odom", near("/tb3_07/scan")),
        "bo": ("/lab/nav_vel", None, near("/lab/tb3_08/scan")),
        "cleo": ("/lab/cleo/cmd_vel", None, near("/lab/cleo/scan")),
        "dan": ("/lab/dan/cmd_vel", None, near("/lab/dan/scan")),
    }


def near(topic: str) -> Topic:
    return Topic(topic, "sensor_msgs/LaserScan", 0.5)


def test_one_robot_has_one_role() -> None:
    for text in (
        '[robots.ada]\nnamespace = "tb3"\n[robots.bo]\nnamespace = "/tb3"\n',
        '[robots.ada]\nnamespace = "bo"\n[robots.bo]\n',
    ):
        robots = read_robots(text)
        assert not robots.ok
        (found,) = robots.diagnostics
        assert found.message.endswith("has this namespace too: give each its own")


@pytest.mark.parametrize(
    ("text", "other", "at"),
    [
        ('[robots.ada]\ntopic = "/base"\n[robots.bo]\ntopic = "/base"\n', "ada", 1),
        ('[ros]\nnamespace = "/lab"\n[robots.ada]\ntopic = "base"\n[robots.bo]\ntopic = "/lab/base"\n', "ada", 1),
        ('[robots.ada]\ntopic = "/bo/cmd_vel"\n[robots.bo]\n', "bo", 0),
        ('[robots.ada]\nnamespace = "tb3"\n[robots.bo]\ntopic = "/tb3/cmd_vel"\n', "ada", 0),
    ],
)
def test_one_topic_has_one_role(text: str, other: str, at: int) -> None:
    robots = read_robots(text)
    (found,) = robots.diagnostics
    assert found.message == f"`{other}` listens on this topic too: give each its own"
    quoted = [match.span(1) for match in re.finditer(r'topic = (".*?")', text)]
    assert (found.span.start, found.span.end) == quoted[at]


def test_an_unfinished_section_says_nothing_about_the_topic_of_another_one() -> None:
    robots = read_robots('[robots.ada]\ntopic = "/base"\nprofile =\n[robots.bo]\ntopic = "/base"\n')
    assert "listens on this topic too" not in "".join(found.message for found in robots.diagnostics)
