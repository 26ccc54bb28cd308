"""Diagnostics of robots' limits, at the item that exceeds them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from improv_core.diagnostics import MAX_SHOWN, Diagnostic
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from improv_core.score.profiles import BUILT_IN
from tests.program import drawing
from tests.program.drawing import drawn

TOML = """
[robots.burger]
profile = "turtlebot3_burger"
[robots.create]
profile = "create3"
[robots.omni]
profile = "holonomic"
[profiles.tall]
base = "turtlebot3_burger"
smooth = true
near = 0.2
[robots.tower]
profile = "tall"
[profiles.ackermann]
step = 0.5
motions = ["forward", "turn"]
turning_radius = 0.6
[robots.car]
profile = "ackermann"
[profiles.soft]
step = 0.2
max_linear_acceleration = 1.5
max_angular_acceleration = 3
[robots.slow_turner]
profile = "soft"
[profiles.softer]
base = "soft"
smooth = true
[robots.gentle]
profile = "softer"
"""
ROBOTS = read_robots(TOML)
assert ROBOTS.ok


def check(expected: str) -> None:
    """Check that these are the errors and warnings of the lines, for these robots."""
    drawing.check(expected, robots=TOML)


def test_movements_too_fast_to_be_smoothed() -> None:
    """Smoothing makes a movement 4/3 times as fast in its middle. One that is too fast anyway has the
    usual message, and one that is never smoothed has none."""
    check("""
        beat 49
        tower $ forward left forward
    """)
    check("""
        beat 60
        a = left forward
        tower $ left a backward
                     ^ too-fast: smoothed, this would reach 0.267 m/s, over tower's limit of 0.22 m/s, so it is not smoothed: use `beat 49`, or `slow 2 ( … )` around the whole movement
        burger $ forward
    """)
    check("""
        beat 120
        tower $ forward
                ^^^^^^^ too-fast: 0.4 m/s is over tower's limit of 0.22 m/s: use `beat 66`, or `slow 2 ( … )` around the whole movement
    """)
    check("""
        beat 60
        tower $ until near (forward) (forward left || left forward) ease (scale 1/2 forward) repeat forward
    """)


def test_a_robot_set_to_smooth_plays_smoothed_movements() -> None:
    """Smooth only within its limits. Other robots play the same program as it is written."""
    program = "tower burger $ left forward\n"
    speeds = {
        name: [segment[2:] for segment in robot["segments"]]
        for name, robot in compiled(analyze(f"beat 60\n{program}", ROBOTS))["robots"].items()
    }
    assert speeds["burger"] == [[0, 0, 0, math.pi / 2], [0.2, 0, 0, 0]]
    assert [yaw / math.pi * 2 for *_, yaw in speeds["tower"][:-1]] == pytest.approx([1 / 3, 1, 4 / 3, 1, 1 / 3])
    assert speeds["tower"][-1] == [0.2, 0, 0, 0], "that would be too fast"
    slower = compiled(analyze(f"beat 45\n{program}", ROBOTS))["robots"]
    assert len(slower["tower"]["segments"]) == 10
    assert slower["tower"]["seconds"] == slower["burger"]["seconds"]


@pytest.mark.parametrize("profile", BUILT_IN)
def test_every_built_in_robot_can_dance_the_examples_for_robots(profile: str) -> None:
    folder = Path(__file__).parents[2] / "examples" / "robots"
    ours = 'base = "turtlebot4"'
    written = (folder / "improv.toml").read_text("utf-8")
    assert ours in written
    robots = read_robots(written.replace(ours, f'base = "{profile}"'))
    assert robots.ok
    programs = sorted(folder.glob("*.improv"))
    assert len(programs) == 3
    for program in programs:
        source = program.read_text("utf-8").strip("\n")
        analysis = analyze(source, robots)
        if (profile, program.stem) == ("husky", "canon"):  # its controller turns by 1 rad/s² at most
            assert {each.code for each in analysis.diagnostics} == {"too-sudden"}
        else:
            assert drawn(analysis, hints=False) == source


def test_a_velocity_that_a_robot_cannot_get_to_in_time_is_too_sudden() -> None:
    """The robot would end elsewhere. If it gets there before the next velocity follows, it only lags."""
    check("""
        beat 60
        slow_turner $ [halfleft halfright] rest
                                ^^^^^^^^^ too-sudden: this lasts 0.5 s, but slow_turner needs 1.05 s to get to that velocity: use `beat 41`, or `slow 2 ( … )` around the whole movement
        slow_turner $ halfleft halfright [forward rest]
        slow_turner $ fast 4 (forward rest)
                              ^^^^^^^ too-sudden: this lasts 0.25 s, but slow_turner needs 0.533 s to get to that velocity: use `beat 41`, or `slow 2 ( … )` around the whole movement
        burger $ [halfleft halfright]
    """)
    check("""
        beat 41
        slow_turner $ [halfleft halfright] rest
        slow_turner $ fast 4 (forward rest)
    """)
    check("""
        beat 60
        slow_turner $ slow 3/2 [halfleft halfright] rest
        slow_turner $ repeat 1000000 [halfleft halfright]
                                               ^^^^^^^^^ too-sudden: this lasts 0.5 s, but slow_turner needs 1.05 s to get to that velocity: use `beat 41`, or `slow 2 ( … )` around the whole movement
    """)


def test_smoothing_may_need_more_than_a_robot_s_accelerations() -> None:
    """Smoothed, each half turn reverses twice: its first and last steps are steep."""
    check("""
        beat 60
        gentle $ slow 2 halfleft
        gentle $ fast 2 halfleft
                        ^^^^^^^^ too-sudden: this lasts 0.125 s, but gentle needs 0.349 s to get to that velocity: use `beat 35`, or `slow 2 ( … )` around the whole movement
    """)


def test_too_fast_advises_a_tempo_and_a_factor() -> None:
    check("""
        beat 60
        quick = [forward forward]
        burger $ left quick forward
                      ^^^^^ too-fast: 0.4 m/s is over burger's limit of 0.22 m/s: use `beat 33`, or `slow 2 ( … )` around the whole movement
        burger $ [left left]
                  ^^^^ too-fast: 3.14 rad/s is over burger's limit of 2.84 rad/s: use `beat 54`, or `slow 2 ( … )` around the whole movement
        burger omni $ scale 1/2 (forward || forward) rest
    """)


def test_too_fast_marks_the_fastest_item() -> None:
    check("""
        beat 60
        burger $ ease [forward forward] forward
                       ^^^^^^^ too-fast: 0.533 m/s is over burger's limit of 0.22 m/s: use `beat 24`, or `slow 3 ( … )` around the whole movement
        burger $ fast 2 forward left fast 3 forward
                                            ^^^^^^^ too-fast: 0.6 m/s is over burger's limit of 0.22 m/s: use `beat 22`, or `slow 3 ( … )` around the whole movement
    """)


def test_a_base_that_stops_while_it_drives_backward_is_marked_at_the_word() -> None:
    limit = "`create` stops by itself once it has driven 0.15 m backward: turn it around, or lift that limit"
    lines = f"""
        beat 60
        create $ repeat 10 backward
                           ^^^^^^^^ too-far-back: {limit}
        back = scale 1/2 backward
        create $ scale 3/4 backward forward back left back
                                                      ^^^^ too-far-back: {limit}
        create $ repeat 9 (back forward) repeat 3 (forward scale 3/4 backward)
        create $ left reflect frontal (forward forward)
                                       ^^^^^^^ too-far-back: {limit}
        burger $ backward
    """
    drawing.check(lines, hints=True, robots=TOML)


def test_all_movements_under_senses_are_checked() -> None:
    over = "0.4 m/s is over burger's limit of 0.22 m/s"
    check(f"""
        beat 60
        burger $ until cue repeat (left repeat 5 scale 1/10 forward [forward forward])
                                                                     ^^^^^^^ too-fast: {over}: use `beat 33`, or `slow 2 ( … )` around the whole movement
        burger $ if cuee [forward forward] else left
                    ^^^^ unknown-sense: `cuee` is not a sense: did you mean `cue`?
                          ^^^^^^^ too-fast: {over}: use `beat 33`, or `slow 2 ( … )` around the whole movement
        burger $ (until not cuee repeat [forward forward]) left
                            ^^^^ unknown-sense: `cuee` is not a sense: did you mean `cue`?
                                         ^^^^^^^ too-fast: {over}: use `beat 33`, or `slow 2 ( … )` around the whole movement
    """)


def test_robots_must_be_listed_and_able() -> None:
    check("""
        burgr $ forward
        ^^^^^ unknown-robot: `burgr` is not in improv.toml: did you mean `burger`?
        turtle $ left
        ^^^^^^ unknown-robot: `turtle` is not in improv.toml: add `[robots.turtle]` to improv.toml
        omni burger $ left strafeleft
                           ^^^^^^^^^^ unsupported-direction: `burger` can't move sideways: use another motion, or a profile other than turtlebot3_burger, such as holonomic
        omni $ strafeleft up
                          ^^ unsupported-direction: `omni` can't move up or down: use another motion, or a profile other than holonomic, such as quadrotor
    """)


@pytest.mark.parametrize(
    "robots",
    ['[robots.ada]\nnamespace = "/bo"\n', '[ros]\nnamespace = "/lab"\n[robots.ada]\nnamespace = "bo"\n'],
)
def test_a_name_and_the_role_of_the_robot_with_that_name_would_drive_one_robot(robots: str) -> None:
    program = "ada $ forward\nbo $ left\n"
    (found,) = analyze(program, read_robots(robots)).diagnostics
    assert (found.code, program[slice(*found.span)]) == ("unknown-robot", "bo")
    assert found.message == "`bo` is not in improv.toml, and its namespace is that of `ada`: write `ada` here"
    assert [fix.title for fix in found.fixes] == ["Change to ada"]


def test_a_car_turns_only_as_it_drives_and_on_no_tighter_curve_than_it_can() -> None:
    wide = "it needs a radius of 0.6 m, as in `repeat 2 forward || slow 2 left`"
    check(f"""
        car $ forward left
                      ^^^^ unsupported-direction: `car` can't turn on the spot: {wide}
        car $ backward (forward || left)
                                   ^^^^ unsupported-direction: `car` can't drive a curve with a radius of 0.32 m: {wide}
        car $ until cue repeat ease left
                                    ^^^^ unsupported-direction: `car` can't turn on the spot: {wide}
        car $ (forward || halfleft) fast 2 (backward || halfright) reverse (repeat 2 forward || slow 2 left) rest
    """)


def test_a_curve_of_exactly_the_turning_radius_is_allowed() -> None:
    profile = f'motions = ["forward", "turn"]\nturning_radius = 0.6\nstep = {math.pi / 2 * 0.6!r}\n'
    robots = read_robots(f'[robots.car]\nprofile = "car"\n[profiles.car]\n{profile}')
    assert analyze("car $ forward || left", robots).ok
    assert not analyze("car $ forward || scale 1001/1000 left", robots).ok


def test_an_edit_of_the_tempo_checks_all_lines() -> None:
    analysis = analyze("beat 60\nburger $ forward\nburger $ left\n", ROBOTS)
    assert analysis.diagnostics == ()
    codes = [each.code for each in analysis.edited(5, 7, "120").diagnostics]
    assert codes == ["too-fast", "too-fast"]
    assert analysis.edited(5, 7, "120").edited(5, 8, "60").diagnostics == ()


def test_diagnostics_held_back_are_complete_once_they_are_shown() -> None:
    lines = [
        *("burger $ strafeleft", "burger $ fast 9 forward", "burgr $ left", "burger $ left strafeleft fast 9 forward"),
        "burger $ fast 99 left",
    ]
    text = "".join(f"{line}\n" for line in lines * (MAX_SHOWN // 4))

    def shown(analysis: Analysis) -> list[Diagnostic]:
        return [each for each in analysis.diagnostics if not each.code.startswith("more-")]

    analysis = analyze(text, ROBOTS)
    more = analysis.diagnostics[-1]
    assert (len(shown(analysis)), more.code) == (MAX_SHOWN, "more-errors")
    for left in (550, 300, 20):
        start = sum(len(line) + 1 for line in text.splitlines()[:-left])
        edited = analysis.edited(0, start, "")
        assert shown(edited) == shown(analyze(text[start:], ROBOTS))
        assert all(each.message for each in edited.diagnostics)
