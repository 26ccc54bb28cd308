"""Several programs as one: each robot plays what it plays in its own program."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

from improv_core.ide.merging import Dance, Merged, MergeError, as_robot, merge
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of, starts_of
from improv_core.program.files import analyze_file
from improv_core.robots.config import read_robots
from improv_core.score.meetings import check_room
from improv_core.syntax.formatter import format_text

EXAMPLES = Path(__file__).parents[2] / "examples"
ALONE = {"cue": "senses decide when its scenes begin, so others can't play at the same time"}
"""The examples that can't be merged, and why."""
DANCES = sorted([*EXAMPLES.glob("*.improv"), *EXAMPLES.glob("senses/*.improv")])
MAX_BEATS = 60
"""Segments of a robot that are compared."""

Stroke = tuple[float, float, list[float]]


@dataclass(frozen=True)
class Played:
    """Times in seconds at which a robot moves, and its movements, equal velocities in a row as one, and the end of the
    known part."""

    strokes: Sequence[Stroke]
    until: float

    def before(self, end: float) -> list[float]:
        """Return all numbers of the strokes up to a second."""
        shown = [(start, min(stop, end), *velocity) for start, stop, velocity in self.strokes if start < end - 1e-6]
        return [number for stroke in shown for number in stroke]


@cache
def program(path: Path) -> Analysis:
    return analyze_file(path)


@cache
def alone(path: Path) -> dict[str, Played]:
    return played(program(path))


def played(analysis: Analysis) -> dict[str, Played]:
    robots = compiled(analysis, MAX_BEATS)["robots"]
    return {name: joined(robot["segments"], robot["truncated"]) for name, robot in robots.items()}


def joined(segments: Sequence[Sequence[float]], truncated: bool) -> Played:
    found: list[Stroke] = []
    for start, seconds, *velocity in segments:
        if not any(velocity):
            continue
        if found and found[-1][2] == velocity and found[-1][1] == pytest.approx(start):
            found[-1] = (found[-1][0], start + seconds, velocity)
        else:
            found.append((start, start + seconds, velocity))
    return Played(found, segments[-1][0] + segments[-1][1] if truncated else math.inf)


def merged(*texts: str, names: str = "abcdef") -> Merged:
    return merge([Dance(name, analyze(text)) for name, text in zip(names, texts, strict=False)])


def check_same(result: Merged, befores: Sequence[dict[str, Played]]) -> None:
    analysis = analyze(result.text)
    assert analysis.ok
    after = played(analysis)
    assert sorted(after) == sorted(new for names in result.robots for new in names.values())
    for before, names in zip(befores, result.robots, strict=True):
        assert names.keys() == before.keys()
        for old, new in names.items():
            until = min(before[old].until, after[new].until)
            assert after[new].before(until) == pytest.approx(before[old].before(until))


def test_robots_of_merged_examples_play_the_same_as_alone() -> None:
    paths = [path for path in DANCES if path.stem not in ALONE]
    for together in (paths, *zip(paths, paths, strict=True), *pairwise(paths)):
        sources = [Dance(path.stem, program(path)) for path in together]
        check_same(merge(sources), [alone(path) for path in together])


@pytest.mark.parametrize("name", ALONE)
def test_a_failed_merge_has_a_reason(name: str) -> None:
    path = next(path for path in DANCES if path.stem == name)
    with pytest.raises(MergeError, match=f"^{name}: {ALONE[name]}$"):
        merge([Dance(name, program(path)), Dance("other", analyze("r $ forward"))])


def test_merged_examples_stand_apart_at_the_start() -> None:
    sources = [Dance(path.stem, program(path)) for path in DANCES if path.stem not in ALONE]
    result = merge(sources)
    score = score_of(analyze(result.text))
    own = {new: place for place, names in enumerate(result.robots) for new in names.values()}
    met = [meeting.robots for meeting in check_room(score).meetings if meeting.beat == 0]
    assert [(one, other) for one, other in met if own[one] != own[other]] == []
    assert format_text(result.text) == result.text


@pytest.mark.parametrize(
    "text",
    [
        "r $ repeat 20 forward",
        "r $ repeat 40 (forward scale 1/20 left)",
        "r $ repeat (repeat 20 forward left)",
        "r $ repeat 30 (rest rest rest forward)",
        "s at 0 3\nr s $ repeat 15 (forward || scale 1/9 left)",
    ],
)
def test_robots_of_different_programs_do_not_meet(text: str) -> None:
    result = merged(*(f"r at 0 0 facing {degrees}\n{text}" for degrees in (0, 90, 200)))
    meetings = check_room(score_of(analyze(result.text))).meetings
    assert [robots for robots, *_ in meetings if robots[0][0] != robots[1][0]] == []


@pytest.mark.parametrize(
    ("texts", "body"),
    [
        (("r $ forward", "r $ left"), ["a $ forward", "b $ left"]),  # robots
        (("r s $ forward", "r $ left"), ["a_r a_s $ forward", "b $ left"]),
        (("x = left\nr $ x", "x = right\nr $ x"), ["x = left", "a $ x", "x_b = right", "b $ x_b"]),  # definitions
        (
            ("x = left\nr $ x", "x n = repeat n right\nx_b = rest\nr $ x 2 x_b"),
            ["x = left", "a $ x", "x_b_2 n = repeat n right", "x_b = rest", "b $ x_b_2 2 x_b"],
        ),
        (("x = left\nx = x x\nr $ x", "r $ rest"), ["x = left", "x = x x", "a $ x", "b $ rest"]),
        (
            ("near = left\nr $ until near near", "near = right\nr $ until near near"),  # a sense keeps its name
            ["near = left", "a $ until near near", "near_b = right", "b $ until near near_b"],
        ),
        (
            ("head = left\nr $ head", "p is puppet\np $ head left"),  # a body part
            ["head_a = left", "a $ head_a", "b is puppet", "b $ head left"],
        ),
        (("r $ forward", "beat 30\nr $ left right"), ["a $ forward", "b $ slow 2 (left right)"]),  # tempos
        (("beat 90\nr $ forward", "r $ left"), ["a $ forward", "b $ slow 3/2 (left)"]),
        (
            ("r s $ forward\ns $ rest rest\n---\nr $ left", "r $ rest"),  # scenes
            ["a_r a_s $ forward", "a_s $ rest rest", "a_r $ repeat 2 rest", "a_r $ left", "b $ rest"],
        ),
        (("r $ repeat left\n---\ns $ left", "r $ rest"), ["a_r $ repeat left", "b $ rest"]),
    ],
)
def test_programs_are_merged_line_by_line(texts: Sequence[str], body: Sequence[str]) -> None:
    lines = [line for line in merged(*texts).text.splitlines() if line and line[0] != "#" and " at " not in line]
    assert [line for line in lines if not line.startswith("beat")] == body
    if "s $ left" not in texts[0]:  # a robot that never moves has no part
        check_same(merged(*texts), [played(analyze(text)) for text in texts])


@pytest.mark.parametrize(
    ("texts", "opening", "notes"),
    [
        (("bar 3\nr $ left", "bar 3\nr $ left"), ["bar 3"], []),
        (("bar 3\nr $ left", "bar 4\nr $ left"), [], ["no bar: the programs don't agree on its length"]),
        (("room 4 3\nr at 1 0\nr $ left", "room 2 5\nr at 0 0\nr $ left"), ["room 7 5"], []),
        (("room 4 3\nr $ left", "r $ left"), [], ["no room: only some of the programs have one"]),
        (
            ("beat 90\nr $ left", "beat 60\nr $ left"),
            ["beat 90"],
            ["the tempo is 90: b keeps its speed with `slow`"],
        ),
        (("r $ left\n---\nr $ left", "r $ left"), [], ["no scenes: robots rest until theirs begin"]),
    ],
)
def test_shared_lines_appear_once(texts: Sequence[str], opening: Sequence[str], notes: Sequence[str]) -> None:
    result = merged(*texts)
    lines = result.text.split("\n\n")[0].splitlines()
    assert [line for line in lines if " at " not in line] == opening
    assert result.notes == notes


def test_robots_keep_how_they_stand_to_each_other() -> None:
    starts = starts_of(analyze(merged("ada at 1 2 facing 90\nbo at 3 2\nada bo $ rest", "r $ rest").text))
    ada, bo = starts["a_ada"], starts["a_bo"]
    assert (bo.x - ada.x, bo.y - ada.y) == pytest.approx((2, 0))
    assert ada.heading == pytest.approx(1.5707963)


def test_places_are_round_numbers() -> None:
    texts = ("r $ repeat 5 (forward 1m left 72deg)", "s t u at circle 1.5\ns t u $ forward")
    lines = [line for line in merged(*texts).text.splitlines() if " at " in line]
    assert lines == [
        "a at -2.6 -0.8",
        "b_s at 1.7 1.15 facing -90",
        "b_t at 0.401 -1.1 facing 30",
        "b_u at 2.999 -1.1 facing 150",
    ]


@pytest.mark.parametrize(
    ("name", "robot"),
    [
        ("José Luis", "Jose_Luis"),
        ("阿明", "AMing"),
        ("Анна", "Anna"),
        ("123", "dancer_123"),
        ("forward", "forward_1"),
        ("x" * 99, "x" * 30),
        ("a\u202eb\x00", "ab"),
    ],
)
def test_names_of_programs_become_names_of_robots(name: str, robot: str) -> None:
    assert as_robot(name) == robot


def test_programs_with_one_name_are_told_apart() -> None:
    sources = [Dance("ada", analyze(text)) for text in ("r $ left", "r $ right", "r s $ rest")]
    names = [dict(each) for each in merge(sources).robots]
    assert names == [{"r": "ada"}, {"r": "ada_2"}, {"r": "ada_r", "s": "ada_s"}]


@pytest.mark.parametrize(
    ("text", "toml", "problem"),
    [
        ("r $ forwad", "", "b: it has errors: fix them first"),
        ("x = left", "", "b: it has no robots: add a line such as `ada $ forward`"),
        (
            "r $ left",
            "[world]\nwalls = [[0, 0, 1, 1]]",
            "b: its improv.toml has obstacles, which can't be moved: remove them first",
        ),
        (
            "r $ left",
            "[profiles.big]\nstep = 3\n[robots.r]\nprofile = 'big'",
            "b: `r` is described in its improv.toml: remove it there, or play it alone",
        ),
        (
            "r at 1000 0\ns at -1000 0\nr s $ left",
            "",
            "these need 2,002 m side by side, and 2,000 m is the most: merge fewer, or leave out b",
        ),
    ],
)
def test_a_program_that_does_not_fit_is_refused(text: str, toml: str, problem: str) -> None:
    with pytest.raises(MergeError) as refused:
        merge([Dance("a", analyze("r $ left")), Dance("b", analyze(text, read_robots(toml)))])
    assert str(refused.value) == problem
