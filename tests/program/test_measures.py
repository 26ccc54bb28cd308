"""Measures: lengths and angles in units of the floor, which no profile changes, and the errors in them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from improv_core.syntax.formatter import format_text
from tests.program.drawing import check
from tests.program.test_fixes import fixed

BODY = """
[robots.ada]
profile = "own"
[robots.bo]
profile = "own"
[profiles.own]
step = 0.5
quarter_turn = 92
[profiles.own.body.head]
left = { joint = "yaw", degrees = -30 }
up = { joint = "lift", meters = -0.1 }
[profiles.own.body.left_arm]
up = { joint = "left", degrees = 40 }
mirror = "right_arm"
[profiles.own.body.right_arm]
up = { joint = "right", degrees = -40 }
[profiles.own.body.arms]
parts = ["left_arm", "right_arm"]
"""


def segments(program: str, robots: str = "") -> dict[str, list[list[float]]]:
    analysis = analyze(program, read_robots(robots))
    assert analysis.ok, analysis.diagnostics
    return {name: part["segments"] for name, part in compiled(analysis)["robots"].items()}


def test_measures_at_the_same_time_add_up() -> None:
    assert segments("ada $ forward 1m || forward 50cm", BODY)["ada"] == [[0, 1, 1.5, 0, 0, 0]]


def test_a_measure_depends_on_no_step_and_no_quarter_turn() -> None:
    moved = segments("ada $ forward 1m left 90deg left 90deg radius 1m left radius 2m", BODY)["ada"]
    turn = math.radians(92)
    expected = [(1, 0), (0, math.pi / 2), (math.pi / 2, math.pi / 2), (2 * turn, turn)]
    assert [(x, yaw) for _, _, x, _, _, yaw in moved] == [pytest.approx(each) for each in expected]


def test_a_step_and_its_length_are_one_segment() -> None:
    assert segments("bo $ forward 50cm forward", BODY)["bo"] == [[0, 2, 0.5, 0, 0, 0]]


@pytest.mark.parametrize(
    ("movement", "joints"),
    [
        ("head (left 20deg)", {"yaw": [[0, 1, -math.radians(20)]]}),
        ("head right 20deg", {"yaw": [[0, 1, math.radians(20)]]}),
        ("head up 10cm", {"lift": [[0, 1, -0.1]]}),
        ("head (up 10cm || left 90deg)", {"lift": [[0, 1, -0.1]], "yaw": [[0, 1, -math.pi / 2]]}),
        ("arms up 90deg", {"left": [[0, 1, math.pi / 2]], "right": [[0, 1, -math.pi / 2]]}),
        ("reflect sagittal left_arm fast 2 up 45deg", {"right": [[0, 0.5, -math.pi / 2]]}),
        ("head (up || up 10cm)", {"lift": [[0, 1, -0.2]]}),
    ],
)
def test_a_joint_takes_measures_in_the_sense_of_its_direction(movement: str, joints: dict[str, Any]) -> None:
    analysis = analyze(f"ada $ {movement}", read_robots(BODY))
    assert analysis.ok, analysis.diagnostics
    found = compiled(analysis)["robots"]["ada"]["joints"]
    assert found == {name: [pytest.approx(each) for each in stretches] for name, stretches in joints.items()}


def test_units_that_performers_do_not_take() -> None:
    check(
        """
        x = forward 90deg
        nod = up 20deg
        ada $ head nod arms nod
                   ^^^ wrong-measure: under `head`, `up` takes a length, such as `up 1m`, and `nod` gives it an angle
        ada $ x left 1m
              ^ wrong-measure: `forward` takes a length, such as `forward 1m`, and `x` gives it an angle
                ^^^^^^^ wrong-measure: `left` takes an angle, such as `left 90deg`
        ada $ head left 90deg radius 1m
                   ^^^^^^^^^^^^^^^^^^^^ part-direction: `head` has no direction `forward`, so `forward` and `backward` do nothing: use another, or declare it in the profile own
                   ^^^^^^^^^^^^^^^^^^^^ wrong-measure: under `head`, nothing drives along a circle: write the turn without `radius`
        """,
        robots=BODY,
    )


def test_measures_that_are_wrong_anywhere() -> None:
    check(
        """
        go n = forward n || left 360/n
                       ^ missing-unit: `forward n` needs a unit, such as `n*1m`
                                 ^^^^^ missing-unit: `left 360/n` needs a unit, such as `360deg/n`
        r $ left radius 2 || forward radius 1m
                        ^ missing-unit: `radius 2` needs a unit, such as `2m`
                             ^^^^^^^^^^^^^^^^^ wrong-measure: `radius` needs a turn: write it behind `left` or `right`, not `forward`
        r $ rest 1m left 0deg
                 ^^ wrong-measure: `rest` takes no measure: it lasts one beat
                         ^^^^ bad-number: write this measure as a number above 0, or write `rest` to stand still
        r $ forward 10in up 3 cm
                    ^^^^ missing-unit: `in` is not a unit here: write `forward 0.254m`
                            ^^^^ missing-unit: write the unit directly behind the number: `up 3cm`
        r $ left 90 degrees forward 1cm*2m
                 ^^^^^^^^^^ missing-unit: `degrees` is not a unit here: write `left 90deg`
                                    ^^^^^^ wrong-measure: a measure has one unit: remove `m`
        r $ turn 90deg [Forward 1m left 1½m]
            ^^^^ unknown-name: `turn` is not defined: did you mean `left` or `right`?
                        ^^^^^^^ unknown-name: `Forward` is not defined: did you mean `forward`?
                                         ^^ unknown-name: `½m` is not defined: write `3/2m`: this is a vulgar fraction one half, U+00BD
        r $ left radius (spin 9°)
                        ^ syntax: write a length after `radius`, such as `1m`
                         ^^^^ unknown-name: `spin` is not defined: did you mean `left` or `right`?
        room 6deg 4
             ^^^^ wrong-measure: this takes a length, such as `50cm`
        ada at 1 m 2
                 ^ syntax: write the unit directly behind the number: `1m`
        """
    )


def made_by_fixes(program: str) -> list[str]:
    analysis = analyze(program)
    return [fixed(analysis, fix) for fix in analysis.diagnostics[0].fixes]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("r $ forward 100", ["r $ forward 100m", "r $ forward 100cm"]),
        ("r $ halfleft 30deg", ["r $ left 30deg"]),
        ("r $ left radius 2", ["r $ left radius 2m"]),
        ("go n = forward n m\nr $ go 1", ["go n = forward n*1m\nr $ go 1"]),
        ("go n = forward 2*n\nr $ go 1", ["go n = forward 2m*n\nr $ go 1"]),
        ("go n = forward n ft\nr $ go 1", ["go n = forward n*0.3048m\nr $ go 1"]),
        ("r $ backward -50cm", ["r $ forward 50cm"]),
        ("ada at 1 m 2", ["ada at 1m 2"]),
        ("room 6 meters 4M", ["room 6m 4M"]),
        ("ada at 0 0 facing 90 degrees", ["ada at 0 0 facing 90deg"]),
        ("ada at -1 ft 2", ["ada at -0.3048m 2"]),
        ("r $ left 90 degrees", ["r $ left 90deg"]),
        ("r $ turn 90deg", ["r $ left 90deg", "r $ right 90deg"]),
        ("r $ walk 2 feet", ["r $ forward 2 feet"]),
        ("r $ forward 60CM", ["r $ forward 60cm"]),
        ("r $ forward 1½m", ["r $ forward 3/2m"]),
        ("r $ forward 1e-1m", ["r $ forward 1/10m"]),
        ("r $ left \u0669\u0660deg", ["r $ left 90deg"]),
        ("r $ left 90 °", ["r $ left 90°"]),
        ("r $ forward 1m*1cm", ["r $ forward 1m*1"]),
        ("r $ forward-1in", ["r $ backward 1in"]),
        ("r $ rest 0ft", ["r $ rest ft"]),
        ("r $ ramp 2(.5)up", ["r $ ramp 2 .5 up"]),
        ("x = up\nr $ forward 3x", ["x = up\nr $ forward 3m x", "x = up\nr $ repeat 3 forward x"]),
        ("radius = up\nr $ radius 2m", ["radius = up\nr $ repeat 2 radius m", "radius = up\nr $ scale 2 radius m"]),
    ],
)
def test_fixes_write_units(before: str, after: list[str]) -> None:
    assert made_by_fixes(before) == after


def test_nothing_from_an_argument_is_a_rest() -> None:
    zero = "go n = forward n*1m\nturn n = left 90deg radius n*1m\nr $ go 0 turn 0 forward 1m"
    assert segments(zero)["r"] == [
        [0, 1, 0, 0, 0, 0],
        [1, 1, 0, 0, 0, pytest.approx(math.pi / 2)],
        [2, 1, 1, 0, 0, 0],
    ]


@pytest.mark.parametrize(
    ("program", "same"),
    [
        ("m = forward\nr $ fast 2m repeat 3m", "r $ fast 2 forward repeat 3 forward"),
        ("radius n = scale n up\nm = left\nr $ left radius 2m forward 2m", "r $ left scale 2 up left forward 2m"),
        (
            "radius n (w) = repeat n w\nm n = scale n left\nr $ left radius 2m 3 left",
            "r $ left repeat 2 scale 3 left left",
        ),
        ("f (radius) = left radius\nr $ f up", "r $ left up"),
        ("f radius = left radius*1deg\nr $ f 90", "r $ left 90deg"),
        ("r $ left radius 1m\nradius = up\nr $ left radius", "r $ left radius 1m left up"),
    ],
)
def test_names_keep_their_meanings(program: str, same: str) -> None:
    assert segments(program) == segments(same)
    assert segments(format_text(program)) == segments(program)


def test_a_body_part_called_radius_hides_the_word() -> None:
    robots = read_robots(BODY.replace("head", "radius"))
    analysis = analyze("ada $ left radius up 10cm", robots)
    assert analysis.ok
    assert list(compiled(analysis)["robots"]["ada"]["joints"]) == ["lift"]
    assert not analyze("ada $ left radius 1m", robots).ok


def edited(program: str, before: str, after: str) -> Analysis:
    start = program.index(before)
    return analyze(program).edited(start, start + len(before), after)


def test_an_edit_that_defines_radius_changes_the_lines_below() -> None:
    program = "radios n = scale n up\nm = left\nr $ left radius 2m\n"
    now = edited(program, "radios", "radius")
    assert compiled(now) == compiled(analyze(now.text))
    assert now.diagnostics == analyze(now.text).diagnostics


def test_a_base_that_stops_by_itself_counts_measured_ways_back() -> None:
    check(
        """
        anna $ forward 10cm backward 15cm backward 1cm
                                          ^^^^^^^^^^^^ too-far-back: `anna` stops by itself once it has driven 0.15 m backward: turn it around, or lift that limit
        """,
        robots='[robots.anna]\nprofile = "create3"',
        hints=True,
    )
