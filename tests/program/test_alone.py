"""A hint marks `near` if it can never be true in the simulator, because nothing is there to be near."""

from __future__ import annotations

import pytest

from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from tests.program.drawing import check_all

WHY = "is alone and there are no walls, so in the simulator nothing is ever near it: add `room 6 4`"
PLAY = "r $ repeat (until near (repeat forward) left)"


def test_the_first_word_that_is_never_true_is_marked() -> None:
    check_all(f"""
        dodge (m) = pause near m
                          ^^^^ nothing-near: `r` {WHY}
        r $ dodge repeat 4 forward if not near left else right
        r $ until near repeat left
    """)


def test_a_word_with_another_problem_has_only_that() -> None:
    check_all(f"""
        r $ until near repeat backward
                  ^^^^ looks-ahead: `near` looks only ahead, and this goes backward: declare a sense that looks there in improv.toml
        r $ until near repeat forward
                  ^^^^ nothing-near: `r` {WHY}
    """)  # noqa: E501


@pytest.mark.parametrize(
    "program",
    [
        f"room 6 4\n{PLAY}",
        f"{PLAY}\ns $ left",
        f"r {PLAY.replace('r $', 's $')}",
        f"s at 2 0\n{PLAY}",
        "r $ until bump repeat forward",
        "near = left\nr $ near",
        "x = until near repeat left",
        "r at 1 2",
        "",
    ],
)
def test_something_may_be_near(program: str) -> None:
    assert "nothing-near" not in found(program)


@pytest.mark.parametrize(
    "robots",
    [
        "[world]\nsize = [6, 4]",
        "[world]\nwalls = [[1, 2, 3, 4]]",
        "[world]\ncircles = [{ x = 1, y = 2, radius = 0.5 }]",
        "[world]\nboxes = [{ x = 1, y = 2, width = 1, height = 1 }]",
        '[senses.near]\ntopic = "scan"\nmessage = "sensor_msgs/LaserScan"\nbelow = 0.5',
        '[profiles.mine]\nbase = "turtlesim"\nnear = 1\n[robots.r]\nprofile = "mine"',
    ],
)
def test_improv_toml_may_declare_near(robots: str) -> None:
    assert found(PLAY, robots) == []


def test_a_listed_robot_without_walls_senses_nothing() -> None:
    listed = '[robots.r]\nprofile = "turtlebot4"\n'
    assert found("x = repeat (until near (repeat forward) left)\nr $ x", listed) == ["nothing-near", "missing-sense"]


@pytest.mark.parametrize("line", ["room 6 4", "s $ left", "s at 3 3"])
def test_edits_remove_and_restore_the_hint(line: str) -> None:
    analysis = analyze(f"\n{PLAY}")
    for text, codes in ((line, []), ("", ["nothing-near"])):
        analysis = analysis.edited(0, analysis.text.index("\n"), text)
        assert [each.code for each in analysis.diagnostics] == codes


def found(program: str, robots: str = "") -> list[str]:
    toml = read_robots(robots)
    assert toml.diagnostics == ()
    return [each.code for each in analyze(program, toml).diagnostics]
