"""Faults in words: the news about robots at one look → the lines for people."""

from __future__ import annotations

import math
from typing import get_args

import pytest

from improv_core.safety.fault_rules import FaultBegan, FaultOver, News, Worst
from improv_core.safety.fault_texts import SeenNews, as_line, as_lines, in_words, may_still_move
from improv_core.score.faults import Fault, FaultRules, Response
from improv_core.score.motion import Pose
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, Rejoin

BAD = Worst(0.31, math.radians(4), 1.25)


def part(robot: str) -> Part:
    return Part(robot, (), Profile("disc", step=2.0), Pose(), f"/{robot}/cmd_vel", odom=f"/{robot}/odom")


def lines(
    *news: tuple[str, News], response: Response = "tell", rejoin: Rejoin = "continue", stand: str = ""
) -> list[str]:
    newly = response == "stand"
    found = [SeenNews(part(robot), each, newly or robot in stand, newly) for robot, each in news]
    return as_lines(found, "beat 3", FaultRules(dict.fromkeys(get_args(Fault), response)).response, rejoin)


def same(robots: str, news: News) -> list[tuple[str, News]]:
    return [(robot, news) for robot in robots]


@pytest.mark.parametrize(
    ("robots", "who"),
    [
        ("ab", "a and b are"),
        ("abc", "a, b, and c are"),
        ("abcd", "a, b, c, and 1 more are"),
        ("abcdefghijklmnopqrstuvwxyzABCD", "a, b, c, and 27 more are"),
    ],
)
def test_one_line_names_three_robots_and_counts_the_others(robots: str, who: str) -> None:
    (line, *others) = lines(*same(robots, FaultBegan("gone", BAD)))
    follows = "gone, nothing listens on their topics: check the network, or start their drivers again"
    assert line == f"beat 3: {who} {follows}"
    assert others == [""] * (len(robots) - 1)


@pytest.mark.parametrize(
    ("fault", "begins", "ends"),
    [
        (
            "off_path",
            "a and b are up to 0.31 m and 4 degrees off their paths: "
            "put them back, calibrate them, or look for what holds them up",
            "a and b are back on their paths, they were at most 0.31 m and 4 degrees off",
        ),
        (
            "silent",
            "no poses of a and b have come for 1.2 s: check the network and what publishes their poses",
            "poses of a and b come again, after up to 1.2 s",
        ),
        (
            "jumped",
            "the poses of a and b jumped by up to 0.31 m and 4 degrees: "
            "unless somebody moved them, check the node that publishes them",
            "the poses of a and b no longer jump",
        ),
        (
            "stuck",
            "a and b are told to move but stand: check their motors, their batteries, and what is in their way",
            "a and b are no longer stuck, they were for up to 1.2 s",
        ),
        (
            "gone",
            "a and b are gone, nothing listens on their topics: check the network, or start their drivers again",
            "a and b listen again, after up to 1.2 s, and continue in the middle of the program",
        ),
        (
            "late",
            "commands for a and b leave up to 1250 ms late: close other programs on this machine or play fewer robots",
            "commands for a and b leave in time again, they were at most 1250 ms late",
        ),
    ],
)
def test_one_line_reports_two_robots(fault: Fault, begins: str, ends: str) -> None:
    """The worst of them counts."""
    mild = Worst(0.26, BAD.turn, 1.0)
    assert lines(("a", FaultBegan(fault, mild)), ("b", FaultBegan(fault, BAD))) == [f"beat 3: {begins}", ""]
    assert lines(("a", FaultOver(fault, BAD)), ("b", FaultOver(fault, mild))) == [f"beat 3: {ends}", ""]


def test_one_line_about_joints_names_each_cause_once() -> None:
    """One of three controllers jams."""
    refused, held = (FaultBegan("joints", BAD, why=why) for why in ("arm moves nothing", "arm no longer moves elbow"))
    assert lines(("a", refused), ("b", held), ("c", refused)) == [
        "beat 3: joints of a and c don't follow: arm moves nothing",
        "beat 3: joints of b don't follow: arm no longer moves elbow",
        "",
    ]
    rushed = FaultBegan("off_path", BAD, why="the program hurries")
    assert lines(*same("ab", rushed))[0] == (
        "beat 3: a and b are up to 0.31 m and 4 degrees off their paths: the program hurries"
    )
    over = FaultOver("joints", BAD)
    assert lines(("a", over), ("b", over))[0] == "beat 3: joints of a and b follow again, after up to 1.2 s"


@pytest.mark.parametrize(
    ("news", "response", "rejoin", "end"),
    [
        (FaultBegan("stuck", BAD), "tell", "continue", "what is in their way"),
        (FaultBegan("stuck", BAD), "stand", "continue", "; they stand until you unmute them"),
        (FaultBegan("stuck", BAD), "stop", "continue", "; all robots were stopped: play again once that is fixed"),
        (FaultOver("gone", BAD), "tell", "continue", "after up to 1.2 s, and continue in the middle of the program"),
        (FaultOver("gone", BAD), "tell", "scene", "after up to 1.2 s, and stand until the next scene"),
        (FaultOver("gone", BAD), "tell", "next", "after up to 1.2 s, and stand until the next play"),
        (FaultOver("gone", BAD), "tell", "return", "after up to 1.2 s"),
        (FaultOver("gone", BAD), "tell", "pause", "after up to 1.2 s"),
    ],
)
def test_a_line_ends_with_what_robots_do_now(news: News, response: Response, rejoin: Rejoin, end: str) -> None:
    line, _ = lines(*same("ab", news), response=response, rejoin=rejoin)
    assert line.endswith(end)


def test_different_news_have_lines_of_their_own() -> None:
    """Another kind, that it is over, or that a robot stands."""
    over = FaultOver("jumped", BAD)
    news = [("a", FaultBegan("jumped", BAD)), ("b", FaultBegan("stuck", BAD)), *same("cdef", over)]
    jumped, stuck, back, *others = lines(*news, stand="df")
    assert jumped.startswith("beat 3: the pose of a jumped")
    assert stuck.startswith("beat 3: b is told to move")
    assert back == "beat 3: the poses of c and e no longer jump"
    assert others == ["beat 3: the poses of d and f no longer jump", "", ""]


def test_a_line_reports_that_a_robot_stands_and_that_the_cause_is_over() -> None:
    """No line reports that about the other faults of a robot that stands already."""

    def line(news: News, response: Response, *, newly: bool) -> str:
        return as_line(SeenNews(part("a"), news, True, newly), "beat 3", response, "continue")

    assert line(FaultBegan("silent", BAD), "stand", newly=True).endswith("; it stands until you unmute it")
    assert line(FaultBegan("jumped", BAD), "stand", newly=False).endswith("the node that publishes on /a/odom")
    assert line(FaultOver("off_path", BAD), "tell", newly=False).endswith("4 degrees off")
    assert line(FaultOver("silent", BAD), "stand", newly=False).endswith("after 1.2 s; it stands until you unmute it")


@pytest.mark.parametrize(
    ("worst", "words"),
    [
        (Worst(0.31, math.radians(4)), "0.31 m and 4 degrees"),
        (Worst(0.31, math.radians(1)), "0.31 m and 1 degree"),
        (Worst(0.004, math.radians(20)), "20 degrees"),
        (Worst(0.31, math.radians(0.4)), "0.31 m"),
        (Worst(0.004, 0.0), "0.00 m"),
    ],
)
def test_a_distance_or_a_turn_of_zero_is_left_out(worst: Worst, words: str) -> None:
    assert in_words(worst) == words


@pytest.mark.parametrize(
    ("robots", "line"),
    [
        ("a", "a may still be moving: it is out of reach, so look at it"),
        ("ab", "a and b may still be moving: they are out of reach, so look at them"),
        ("abcde", "a, b, c, and 2 more may still be moving: they are out of reach, so look at them"),
    ],
)
def test_robots_out_of_reach_are_named(robots: str, line: str) -> None:
    assert may_still_move([*robots]) == line
