"""The effect of a fix on a program: before → after."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import example, given

from improv_core.diagnostics import Edit, Fix, applied
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from improv_core.score.performance import SenseSpan
from tests.program.test_keyboards import assert_alike
from tests.random_programs import written


def fixed(analysis: Analysis, fix: Fix) -> str:
    return applied(analysis.text, fix.edits)


def check(code: str, before: str, after: str, robots: str = "") -> None:
    """Check that the first fix of the first diagnostic with this code turns one program into the other."""
    analysis = analyze(before, read_robots(robots))
    fix, *_ = next(each for each in analysis.diagnostics if each.code == code).fixes
    assert fixed(analysis, fix) == after
    assert code not in [each.code for each in analyze(after, read_robots(robots)).diagnostics]


@pytest.mark.parametrize(
    ("code", "before", "after"),
    [
        ("syntax", "r forward", "r $ forward"),
        ("syntax", "fowrard", "turtle1 $ forward"),
        ("syntax", "repat 4 (forward left)", "turtle1 $ repeat 4 (forward left)"),
        ("syntax", "r $ forward | left", "r $ forward || left"),
        ("syntax", "r $ forward, left", "r $ forward left"),
        ("syntax", "r $ ramp 1,2 left", "r $ ramp 1 2 left"),
        ("syntax", "r $ YZ left", "r $ reflect YZ left"),
        ("syntax", "r $ 3 forward left", "r $ repeat 3 forward left"),
        ("unmatched-bracket", "r $ forward)", "r $ forward"),
        ("unmatched-bracket", "r $ [forward)", "r $ [forward]"),
        ("unknown-name", "r $ foward", "r $ forward"),
        ("used-before-definition", "# hi\nr $ x\n\nx = left # yes\n", "# hi\nx = left # yes\nr $ x\n\n"),
        ("reserved-name", "left = right\nr $ right", "my_left = right\nr $ right"),
        ("bad-robot-name", "my-robot $ left", "my_robot $ left"),
        ("duplicate-beat", "beat 60\nr $ left\nbeat 30 # slow\n", "beat 60\nr $ left\n"),
        ("nothing-near", "beat 60\nr $ until near repeat left", "room 6 4\nbeat 60\nr $ until near repeat left"),
        ("nothing-near", "# hi\n x = if near up else left\nr $ x", "# hi\n room 6 4\nx = if near up else left\nr $ x"),
        ("empty-group", "r $ left ()", "r $ left "),
        ("never-performed", "r $ forward left || right", "r $ forward  || right"),
        ("cut-short", "r $ repeat 4 up || left", "r $ repeat 4 up || repeat left"),
        ("cut-short", "r $ [left up] (down) || repeat 3 (left)", "r $ repeat ([left up] (down)) || repeat 3 (left)"),
        ("arguments", "x = left\nr $ x 3 up", "x = left\nr $ repeat 3 x up"),
        ("arguments", "p n (m) = repeat n m\nr $ p", "p n (m) = repeat n m\nr $ p 2 rest"),
        ("arguments", "p n (m) = repeat n m\nr $ p left", "p n (m) = repeat n m\nr $ p 2 left"),
        ("arguments", "p n (m) = repeat n m\nr $ (p 3) up", "p n (m) = repeat n m\nr $ (p 3 rest) up"),
        ("arguments", "p (n) (m)= n m\nr $ p 3 left", "p n (m) = n m\nr $ p 3 left"),
        ("arguments", "b (m) (k) = m || k\nr $ b left", "b (m) (k) = m || k\nr $ b left rest"),
        ("misplaced-canon", "x = canon 2 left\nr s $ x up\n", "x = left\nr s $ canon 2 x up\n"),
        ("misplaced-canon", "x = canon 2 left\ny = x\nr s $ y\n", "x = left\ny = x\nr s $ y\n"),
        ("misplaced-canon", "x = up canon 2 (left)\nr s $ x\n", "x = up (left)\nr s $ x\n"),
        ("unknown-name", "# hi\r\nr $ qqq\r\n", "# hi\r\nqqq = rest\r\nr $ qqq\r\n"),
        ("endless-reverse", "r $ reverse (up repeat left)", "r $ reverse (up repeat 4 left)"),
        ("open-length", "r $ fit 4 repeat left", "r $ fit 4 repeat 4 left"),
        ("parameter-kind", "f n = n left\nr $ f up", "f (n) = n left\nr $ f up"),
        ("parameter-kind", "f a (m) (k) = scale m k a\nr $ f", "f a m (k) = scale m k a\nr $ f"),
        ("uneven-choice", "r $ choose (left slow 2 up [up up])", "r $ choose (left fit 1 slow 2 up [up up])"),
        ("no-effect", "r $ choose left", "r $  left"),
        ("no-effect", "r $ seed 2/3 left", "r $  left"),
        ("no-effect", "r $ scale 1 left", "r $  left"),
        ("no-effect", "r $ left\n---\n", "r $ left\n"),
        ("unused-name", "x = left\nr $ left\n", "r $ left\n"),
        ("open-length", "r $ chance 1/2 until near repeat left", "r $ until near chance 1/2 repeat left"),
        ("open-length", "r $ ease pause  not bump (left up)", "r $ pause  not bump ease (left up)"),
        ("unknown-sense", "r $ if not naer left else up", "r $ if not near left else up"),
        ("instant-sense", "r $ pause cue (left up)", "r $ until cue (left up)"),
        ("instant-sense", "r $ until not cue repeat left", "r $ until cue repeat left"),
        ("short-reach", "r $ until near forward left", "r $ until near repeat forward left"),
    ],
)
def test_the_fix_of_an_error_is_offered(code: str, before: str, after: str) -> None:
    check(code, before, after)


def test_brackets_are_closed_one_after_the_other() -> None:
    analysis = analyze("r $ (forward [left\n")
    for closed in ("r $ (forward [left)\n", "r $ (forward [left])\n"):
        (fix,) = analysis.diagnostics[0].fixes
        analysis = analyze(fixed(analysis, fix))
        assert analysis.text == closed


def test_too_fast_is_slowed_down_as_far_as_needed() -> None:
    robots = '[robots.burger]\nprofile = "turtlebot3_burger"\n'
    check("too-fast", "beat 90\nburger $ forward || left\n", "beat 90\nburger $ slow 2 (forward || left)\n", robots)


def test_only_a_robot_that_is_listed_is_played() -> None:
    (unused,) = analyze("x = left\nbo $ left\n", read_robots("[robots.bo]\n")).diagnostics
    assert [fix.title for fix in unused.fixes] == ["Remove the definition"]
    (unused,) = analyze("ada = left\nbo $ left\n", read_robots("[robots.bo]\n[robots.ada]\n")).diagnostics
    assert [fix.title for fix in unused.fixes] == ["Play it: ada $ …", "Remove the definition"]


ANNA = """
[robots.anna]
profile = "anna"
[profiles.anna]
step = 0.1
motions = ["forward", "turn"]
max_linear = 0.35
"""


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("strafeleft up", "[left forward right] up"),
        ("ease straferight", "ease [right forward left]"),
        ("retrograde straferight", "retrograde rest"),
        ("choose (left straferight)", "choose (left [right forward left])"),
        ("reverse strafeleft", "reverse rest"),
        ("scale 1/2 strafeleft", "scale 1/2 rest"),
        ("forward || strafeleft", "forward || rest"),
        ("left reflect XZ down", "left reflect XZ rest"),
    ],
)
def test_turns_replace_a_direction_if_they_lead_to_the_same_place(before: str, after: str) -> None:
    robots = read_robots(ANNA)
    analysis = analyze(f"anna $ {before}", robots)
    problem = next(each for each in analysis.diagnostics if each.code == "unsupported-direction")
    texts = [fixed(analysis, fix) for fix in problem.fixes]
    assert f"anna $ {after}" in texts
    assert texts[-1] == fixed(analysis, Fix("", (Edit(problem.span, "rest"),)))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("left", ["(repeat 2 forward || slow 2 left)", "(forward || halfleft)", "rest"]),
        ("[halfright]", ["[(forward || halfright)]", "[rest]"]),
        ("forward || left", ["forward || halfleft", "forward || rest"]),
        ("scale 2 left", ["scale 2 rest"]),
        ("halfleft || scale 1/2 forward", ["rest || scale 1/2 forward"]),
    ],
)
def test_a_car_makes_a_turn_that_is_too_tight_as_a_curve(before: str, after: list[str]) -> None:
    car = read_robots('[robots.car]\nprofile = "c"\n[profiles.c]\nstep = 0.5\nturning_radius = 0.6\n')
    analysis = analyze(f"car $ {before}", car)
    [problem] = (each for each in analysis.diagnostics if each.code == "unsupported-direction")
    assert sorted(fixed(analysis, fix) for fix in problem.fixes) == sorted(f"car $ {text}" for text in after)


def test_a_motion_in_a_definition_is_left_to_the_other_robots_that_play_it() -> None:
    analysis = analyze("x = up left\nanna $ x", read_robots(ANNA))
    assert [(each.code, each.fixes) for each in analysis.diagnostics] == [("unsupported-direction", ())]


WORDS = ["left", "forward", "rest", "slow 2 left", "fast 2 up", "repeat 2 right", "repeat left", "choose (left right)"]
FORMS = ["({0} {1})", "({0} || {1})", "[{0}]", "[{0} || {1}]", "reverse ({0} {1})", "repeat 3 [{0} {1}]", "fit 3 ({0})"]
FORMS += [
    "ease ({0})",
    "accumulate ({0} {1})",
    "shuffle ({0} {1})",
    "chance 1/2 ({0})",
    "seed 2 ({0})",
    "cut ({0} {1})",
]
FORMS += ["ramp 1 2 ({0})", "until near ({0} || {1})", "pause near ({0})", "(if near ({0}) else left left)"]
FORMS += ["cut ({0} {1})", "(if not near ({0} {1}) else ())", "until not near ({0})"]


@given(written(WORDS, FORMS, 20))
@example("left || reverse (left left || left forward)")
@example("(left left || left fit 3 (left left))")
@example("((slow 2 left || left left forward) repeat left)")
@example("left || fit 3 (left left)")
@example("until not near (left until near (left) || fast 2 up)")
def test_removing_movements_that_are_never_performed_changes_nothing(movement: str) -> None:
    analysis = analyze(f"cut (m) = m left || rest rest\nr $ {movement}")
    for each in analysis.diagnostics:
        for fix in each.fixes if each.code == "never-performed" else ():
            if fix.title == "Remove it":
                after = analyze(fixed(analysis, fix))
                for script in ([], [SenseSpan("near", None, 1, 2), SenseSpan("near", None, Fraction(7, 2), 4)]):
                    assert_alike(compiled(after, 200, script)["robots"], compiled(analysis, 200, script)["robots"])


def test_related_places_are_shown() -> None:
    analysis = analyze("r $ x\nx = left\nbeat 30\nbeat 60\n")
    related = {
        each.code: [(other.message, analysis.text[slice(*other.span)]) for other in each.related]
        for each in analysis.diagnostics
    }
    assert related == {
        "used-before-definition": [("`x` is defined here", "x")],
        "duplicate-beat": [("the first `beat`", "beat")],
    }


@pytest.mark.parametrize("program", ["x = |up", "x = up|", "r $ repeat 2 | up"])
def test_a_bar_without_a_movement_on_both_sides_is_not_doubled(program: str) -> None:
    assert all(not each.fixes for each in analyze(program).diagnostics if each.code == "syntax")


@pytest.mark.parametrize("program", ["r $ reverse ()", "r $ ()", "r $ left || [ ]", "p (m) = m\nr $ p ()", "r $ (())"])
def test_an_empty_group_that_something_needs_is_not_removed(program: str) -> None:
    assert all(not each.fixes for each in analyze(program).diagnostics if each.code == "empty-group")


def test_a_name_that_no_robot_can_have_is_not_played() -> None:
    (unused,) = analyze("schritt_für_schritt = left").diagnostics
    assert unused.message == "nothing uses `schritt_für_schritt`: use it below or remove this line"
    assert [fix.title for fix in unused.fixes] == ["Remove the definition"]
