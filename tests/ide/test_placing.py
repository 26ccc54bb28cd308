"""Starts that are changed on the page become lines of the program, and the other robots keep their starts."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as some

from improv_core.diagnostics import applied
from improv_core.ide.placing import formed, in_tempo, placed
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.robots.edits import Start

LISTED = "[robots.ada]\nstart = { x = 5 }\n[robots.bo]\n"


def starts_of(program: str, robots: str = "") -> dict[str, Start]:
    """Return the starts of all robots, to the millimeter."""
    poses = {name: part.start for name, part in score_of(analyze(program, read_robots(robots))).parts.items()}
    return {
        name: (round(pose.x, 3), round(pose.y, 3), round(math.degrees(pose.heading), 3)) for name, pose in poses.items()
    }


def check(before: str, starts: Mapping[str, Start], after: str, robots: str = "") -> None:
    """Check that placing robots turns one program into the other, and that the others keep their starts."""
    edits = placed(analyze(before, read_robots(robots)), starts)
    assert edits is not None
    assert applied(before, edits) == after
    wanted = {**starts_of(before, robots), **starts}
    assert starts_of(after, robots) == {name: pytest.approx(start, abs=0.0011) for name, start in wanted.items()}


def test_a_robot_with_a_line_keeps_it() -> None:
    check("ada at 1 2 # here\nada $ left\n", {"ada": (3, 0.5, 0)}, "ada at 3 0.5 # here\nada $ left\n")
    check("ada at 1/2 +2\nada $ left\n", {"ada": (0.5, -1, -90)}, "ada at 0.5 -1 facing -90\nada $ left\n")
    check("ada at 3/2 +2\nada $ left\n", {"ada": (1.5, 2, 0)}, "ada at 3/2 +2\nada $ left\n")
    check("ada bo at circle 1\nada $ left\n", {"ada": (0, 1, -90)}, "ada bo at circle 1\nada $ left\n")
    check("ada at 0 0\n", {"ada": (0.1 + 0.2, -0.00001, 0)}, "ada at 0.3 0\n")
    check("at at 1 2\nat $ left\n", {"at": (3, 4, 0)}, "at at 3 4\nat $ left\n")


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ left\n", "ada at 1 2\nada $ left\n"),
        ("beat 60\nroom 9 9 # m\n\nada $ left\n", "beat 60\nroom 9 9 # m\nada at 1 2\n\nada $ left\n"),
        ("ada $ left\nbo at 0 3\n", "ada $ left\nbo at 0 3\nada at 1 2\n"),
        ("beat 60\r\nada $ left\r\n", "beat 60\r\nada at 1 2\r\nada $ left\r\n"),
        ("x = left\nbeat 60\nada $ x\n", "ada at 1 2\nx = left\nbeat 60\nada $ x\n"),
    ],
)
def test_a_robot_without_a_line_gets_one(before: str, after: str) -> None:
    check(before, {"ada": (1, 2, 0)}, after)


def test_a_line_keeps_its_units() -> None:
    check("ada at 50cm 1m facing 90°\n", {"ada": (0.573, -1.2, 45)}, "ada at 57.3cm -1.2m facing 45°\n")
    before = "ada bo cy at line 60cm around 1m 30cm\n"
    check(before, {"cy": (0, 0, 0)}, "ada bo at line 60cm around 1m 60cm\ncy at 0 0\n")


def test_several_robots_are_placed_at_once() -> None:
    check("bo at 0 3\nada bo $ left\n", {"ada": (1, 2, 0), "bo": (0, 4, 0)}, "bo at 0 4\nada at 1 2\nada bo $ left\n")


def test_a_robot_at_the_end_of_a_line_leaves_it_and_the_others_stay_in_line() -> None:
    check(
        "ada bo cleo at line 1 # us\nada $ left\n",
        {"cleo": (3, 2, 90)},
        "ada bo at line 1 around 0 0.5 # us\ncleo at 3 2 facing 90\nada $ left\n",
    )
    check("a b c at line 1 around 2 0.5\n", {"a": (0, 0, 0)}, "b c at line 1 around 2 0\na at 0 0\n")
    check("a b c at line 1 around 2 0.5\n", {"c": (0, 0, 0)}, "a b at line 1 around 2 1\nc at 0 0\n")


def test_robots_of_a_circle_that_is_broken_get_lines_of_their_own() -> None:
    check(
        "a b c d at circle 1.5 facing out # round\na $ left\n",
        {"b": (-2, 0, 0)},
        "a at 0 1.5 facing 90 # round\nc at 0 -1.5 facing -90\nd at 1.5 0\nb at -2 0\na $ left\n",
    )


def test_two_robots_that_part_have_a_line_each() -> None:
    check("a b at line 2\n", {"a": (3, 0, 0)}, "b at 0 -1\na at 3 0\n")
    check("ada at circle 2 around 1 1\n", {"ada": (0, 0, 0)}, "ada at 0 0\n")


def test_a_place_of_improv_toml_is_overruled() -> None:
    check("ada bo $ left\n", {"ada": (1, 2, 0)}, "ada at 1 2\nada bo $ left\n", LISTED)


@pytest.mark.parametrize("line", ["ada at 1 x", "ada at 1 2000", "ada bo at circle 0", "ada bo at 0 0"])
def test_nothing_is_written_while_a_line_with_at_has_an_error(line: str) -> None:
    analysis = analyze(f"{line}\nada $ left\n")
    assert placed(analysis, {"ada": (0, 0, 0)}) is None
    assert formed(analysis, "line", 1, "in") is None


@pytest.mark.parametrize(
    ("before", "shape", "facing", "after"),
    [
        ("ada bo $ left\n", "line", "in", "ada bo at line 2\nada bo $ left\n"),
        ("ada bo $ left\n", "circle", "in", "ada bo at circle 1\nada bo $ left\n"),
        ("ada bo $ left\n", "circle", "out", "ada bo at circle 1 facing out\nada bo $ left\n"),
        ("a b $ left\na at 1 2 # first\nb at 0 0\nc at 3 3 # last\n", "grid", "in", None),
        ("ada $ left\n", "circle", "in", "ada at 0 0\nada $ left\n"),
    ],
)
def test_a_formation_takes_all_robots(before: str, shape: str, facing: str, after: str | None) -> None:
    edits = formed(analyze(before), shape, 2, facing)
    assert edits is not None
    made = applied(before, edits)
    assert made == (after or "a b $ left\na b c at grid 2 # first\n # last\n")
    assert analyze(made).ok


def test_a_program_without_robots_takes_no_formation() -> None:
    assert formed(analyze("beat 60\n"), "line", 1, "in") is None


thousandths = some.integers(-5000, 5000).map(lambda value: value / 1000)
starts = some.tuples(thousandths, thousandths, some.integers(-179, 180))


@given(
    shape=some.sampled_from(("circle", "line", "grid")),
    size=some.integers(1, 4000),
    around=some.tuples(thousandths, thousandths),
    robots=some.integers(1, 9),
    moved=some.dictionaries(some.integers(0, 9), starts, min_size=1, max_size=4),
)
def test_robots_that_are_not_moved_keep_their_starts(
    shape: str, size: int, around: tuple[float, float], robots: int, moved: Mapping[int, Start]
) -> None:
    names = [f"r{number}" for number in range(10)]  # r9 and others have no line yet
    x, y = around
    line = f"{' '.join(names[:robots])} at {shape} {size / 1000} around {x:.3f} {y:.3f}\n"
    before = f"{line}{' '.join(names)} $ left\n"
    analysis = analyze(before)
    assert analysis.ok
    wanted = {names[number]: start for number, start in moved.items()}
    edits = placed(analysis, wanted)
    assert edits is not None
    after = applied(before, edits)
    assert analyze(after).ok
    found, expected = starts_of(after), {**starts_of(before), **wanted}
    for name, (to_x, to_y, heading) in expected.items():
        now = found[name]
        assert math.dist(now[:2], (to_x, to_y)) < 0.003
        assert abs(math.remainder(now[2] - heading, 360)) < 0.002


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ forward\n", "beat 96\nada $ forward\n"),
        ("# slow\nbar 3\nbeat 60 # a waltz\nada $ forward\n", "# slow\nbar 3\nbeat 96 # a waltz\nada $ forward\n"),
        ("beat\nada $ forward\n", "beat 96\nada $ forward\n"),
        ("", "beat 96\n"),
        ("# nothing yet", "# nothing yet\nbeat 96\n"),
        ("x = forward\nbeat 3/2\nada $ x\n", "x = forward\nbeat 96\nada $ x\n"),
    ],
)
def test_a_tempo_is_written_into_the_first_beat_line_or_above_all(before: str, after: str) -> None:
    text = applied(before, in_tempo(analyze(before), 96))
    assert text == after
    assert analyze(text).diagnostics == analyze(after).diagnostics
    assert analyze(text).tempo == 96
