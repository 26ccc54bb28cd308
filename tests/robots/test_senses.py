"""Sources of senses: `[senses]` in an `improv.toml`."""

from __future__ import annotations

import math

import pytest

from improv_core.robots.config import read_robots
from improv_core.score.senses import BuiltIn, Key, OscName, Source, Topic
from tests.robots.drawing import check

ROBOTS = (
    '[ros]\nnamespace = "lab"\n[robots.anna]\n[robots.bert]\nprofile = "near"\n[profiles.near]\nstep = 1\nnear = 2\n'
)


@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        (
            'topic = "scan"\nmessage = "sensor_msgs/LaserScan"\nbelow = 0.5\nfrom = -30\nto = 45',
            Topic("/lab/anna/scan", "sensor_msgs/LaserScan", 0.5, None, -math.pi / 6, math.pi / 4),
        ),
        ('topic = "/x"\nmessage = "sensor_msgs/Range"\nabove = 2', Topic("/x", "sensor_msgs/Range", above=2.0)),
        (
            'topic = "front/hit"\nmessage = "std_msgs/Bool"\ntimeout = 0',
            Topic("/lab/anna/front/hit", "std_msgs/Bool", timeout=0.0),
        ),
        ('topic = "t"\nmessage = "std_msgs/Float32"\nbelow = -1', Topic("/lab/anna/t", "std_msgs/Float32", -1.0)),
        (
            'topic = "odom"\nmessage = "nav_msgs/Odometry"\nabove = 0\ntimeout = 5',
            Topic("/lab/anna/odom", "nav_msgs/Odometry", above=0.0, timeout=5.0),
        ),
        (
            'topic = "/joy"\nmessage = "sensor_msgs/Joy"\nbutton = 3\ntimeout = 0.5',
            Topic("/joy", "sensor_msgs/Joy", button=3, timeout=0.5),
        ),
        ('key = "d"', Key("d")),
        ('osc = "kick-1"', OscName("kick-1")),
    ],
)
def test_a_declared_sense_is_read(declared: str, expected: Source) -> None:
    robots = check(f"{ROBOTS}[senses.drop]\n{declared}\n")
    assert robots.sense("anna", "drop") == expected
    assert robots.sense_names == ("bump", "near", "cue", "drop")
    assert not robots.lacks("anna", "drop")


def test_each_robot_has_the_built_in_senses() -> None:
    robots = check(ROBOTS)
    assert robots.sense("anna", "near") == BuiltIn("near")
    with pytest.raises(KeyError):
        robots.sense("anna", "drop")
    assert robots.robot("bert").profile.reach == 2.0
    assert robots.robot("anna").profile.reach == robots.robot("anna").profile.step


@pytest.mark.parametrize(
    ("robot", "sense", "lacks"),
    [
        ("anna", "bump", True),
        ("anna", "near", True),
        ("anna", "cue", False),
        ("bert", "near", False),
        ("bert", "bump", True),
        ("unlisted", "bump", False),
    ],
)
def test_a_sense_that_comes_from_nowhere(robot: str, sense: str, lacks: bool) -> None:
    assert check(ROBOTS).lacks(robot, sense) is lacks
    assert not read_robots(f'{ROBOTS}[senses.{sense}s]\nkey = "d"\n').lacks(robot, f"{sense}s")


def test_a_declared_sense_replaces_a_built_in_one() -> None:
    robots = check(f'{ROBOTS}[senses.near]\ntopic = "hit"\nmessage = "std_msgs/Bool"\n')
    assert robots.sense("bert", "near") == Topic("/lab/bert/hit", "std_msgs/Bool")
    assert not robots.lacks("anna", "near")


def test_errors_are_marked_where_they_are() -> None:
    check("""
        [senses.forward]
                ^^^^^^^ robots: `forward` can't be the name of a sense: use a word of your own
        key = "d"
        [senses.2-near]
                ^^^^^^ robots: `2-near` can't be the name of a sense: use a word of your own
        key = "d"
        [senses.cue]
                ^^^ robots: `cue` comes from people: choose another name
        key = "d"
        [senses.a]
                ^ robots: add `topic` and `message`, `key`, or `osc`
        [senses.b]
                ^ robots: add `topic` and `message`, `key`, or `osc`
        below = 1
        [senses.c]
        key = "d"
        topic = "drop"
        ^^^^^ robots: this sense has a key, so `topic` has no effect: remove it
        [senses.d]
        key = "Enter"
              ^^^^^^^ robots: write `key` as one letter, a to z, or one digit
        [senses.e]
        topic = "drop"
        ^^^^^ robots: add `message`, the type on this topic, such as `std_msgs/Bool`
        [senses.g]
        topic = "drop"
        message = "std_msgs/Bool"
        below = 1
        ^^^^^ robots: `below` is not for std_msgs/Bool: remove it
        from = 3
        ^^^^ robots: `from` is not for std_msgs/Bool: remove it
        [senses.h]
        topic = "drop"
        message = "sensor_msgs/Range"
                  ^^^^^^^^^^^^^^^^^^^ robots: add `below` or `above`, a limit in meters
        [senses.i]
        topic = "drop"
        message = "sensor_msgs/Range"
        below = 1
        above = 2
        ^^^^^ robots: write `below` or `above`, not both
        [senses.k]
        topic = "drop"
        message = "sensor_msgs/LaserScan"
        below = 1
        from = 30
               ^^ robots: `from` must be less than `to`, by at most 360: degrees count counterclockwise
        to = -30
        timeout = 0
                  ^ robots: write `timeout` in seconds, from 0.05 to 60
    """)
