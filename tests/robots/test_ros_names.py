"""Names of topics, namespaces, and frames in ROS for the robots of an `improv.toml`."""

from __future__ import annotations

import re

import pytest

from improv_core.robots.config import Robot, read_robots
from improv_core.score.profiles import DEFAULT
from improv_core.score.senses import Topic
from tests.robots.drawing import check


def test_the_name_of_the_node_must_be_valid() -> None:
    assert check('[ros]\nnode = "conductor_1"').node == "conductor_1"
    assert check("").node is None
    found = check("""
        [ros]
        node = "/lab/conductor"
               ^^^^^^^^^^^^^^^^ robots: use the letters a to z, digits, and `_`, not starting with a digit, without `/`
    """)
    assert found.node is None


def test_invalid_names_of_robots_are_marked() -> None:
    found = check("""
        [robots.forward]
                ^^^^^^^ robots: `forward` is a reserved word: choose another name
        [robots."a b"]
                ^^^^^ robots: `a b` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        [robots._a]
                ^^ robots: `_a` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        [robots.9]
                ^ robots: `9` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
    """)
    assert found.robots == {}


def test_topics_that_ros_takes_and_those_that_it_refuses() -> None:
    for topic in ("/cmd_vel", "/a/_b/c1", "/a__b", "/A_", "/" + "a" * 246):
        assert read_robots(f'[robots.a]\ntopic = "{topic}"').robots["a"].topic == topic
    for topic in ("/", "", "/a/", "//a", "/1a", "/a/2", "/a-b", "/a b", "/é", "/~", "/{a}", "/a\\n"):
        found = read_robots(f'[robots.a]\ntopic = "{topic}"')
        assert [diagnostic.span for diagnostic in found.diagnostics] == [(19, 21 + len(topic))]
        assert found.robots["a"].topic == "/a/cmd_vel"


def test_names_that_ros_refuses_are_marked() -> None:
    check("""
        [robots.b]
        reset = "2nd"
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
        [robots.ben]
        odom_frame = "world"
        ^^^^^^^^^^ robots: `odom_frame` is about the poses on `odom`: add `odom`
    """)


def test_wrong_keys_and_values_of_ros() -> None:
    found = check("""
        [ros]
        namespace = "lab/"
                    ^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
        [robots.a]
        frame = "/base_link"
                ^^^^^^^^^^^^ robots: use the letters a to z, digits, `_`, `.`, `-`, and `/`, but no `/` at the start
    """)
    assert found.robots["a"] == Robot(DEFAULT, None, "/a/cmd_vel", "auto")


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


def test_two_robots_cannot_have_the_same_namespace() -> None:
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
def test_two_robots_cannot_listen_on_the_same_topic(text: str, other: str, at: int) -> None:
    robots = read_robots(text)
    (found,) = robots.diagnostics
    assert found.message == f"`{other}` listens on this topic too: give each its own"
    quoted = [match.span(1) for match in re.finditer(r'topic = (".*?")', text)]
    assert (found.span.start, found.span.end) == quoted[at]


def test_an_unfinished_section_says_nothing_about_the_topic_of_another_one() -> None:
    robots = read_robots('[robots.ada]\ntopic = "/base"\nprofile =\n[robots.bo]\ntopic = "/base"\n')
    assert "listens on this topic too" not in "".join(found.message for found in robots.diagnostics)
