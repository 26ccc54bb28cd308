"""Emergency stops, deadman buttons, and how robots rejoin, in `improv.toml`."""

from __future__ import annotations

import json
from fractions import Fraction

from improv_core.score.score import Deadman, Safety, Score
from improv_core.score.score_json import from_json, to_json
from tests.robots.drawing import check


def test_an_emergency_stop_and_a_deadman_button_can_be_set() -> None:
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


def test_errors_in_the_stop_and_deadman_settings() -> None:
    check("""
        [ros]
        stop = "e-stop"
               ^^^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
        deadman = { topic = "joy/", button = 4 }
                            ^^^^^^ robots: use the letters a to z, digits, and `_` between the `/`, not starting with a digit
    """)
    check("""
        [ros]
        stop = "joy"
               ^^^^^ robots: the deadman button is on this topic: the emergency stop needs one of its own
        deadman = { topic = "/joy", button = 4 }
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
