"""One-line reports about a program."""

from pathlib import Path

import pytest

from improv_core.diagnostics import Diagnostic
from improv_core.program.analysis import analyze
from improv_core.program.errors import Deviation, Errors
from improv_core.program.report import as_annotation, summary
from improv_core.text import LineIndex, Span


def test_the_summary_has_the_length_of_each_part() -> None:
    program = "beat 30\nturtle1 $ repeat 8 forward\nturtle2 $ slow 4 left\n"
    assert summary(analyze(program)) == "turtle1 8 beats · turtle2 4 beats, 16.0 s at beat 30"
    assert summary(analyze("r1 $ left\nr2 $ repeat left")) == "r1 1 beat · r2 ∞, endless at beat 60"
    assert summary(analyze("# nothing")) == "no robot plays"


def test_of_many_robots_that_play_equally_long_the_summary_names_the_first() -> None:
    names = " ".join(f"r{number}" for number in range(1, 13))
    program = f"{names} $ repeat 8 forward\nada bo $ left\n"
    assert summary(analyze(program)) == "r1 and 11 more 8 beats each · ada 1 beat · bo 1 beat, 8.0 s at beat 60"
    assert summary(analyze("a b c d $ left")).startswith("a 1 beat · b 1 beat · c 1 beat · d 1 beat, ")


@pytest.mark.parametrize(
    ("off", "words"),
    [
        (Deviation(0.31, 0.07), "0.31 m, 4 degrees off"),
        (Deviation(0.31, 0.0), "0.31 m off"),
        (Deviation(0.001, 0.35), "20 degrees off"),
        (Deviation(0.001, 0.001), "0.00 m off"),
    ],
)
def test_a_deviation_is_written_in_words(off: Deviation, words: str) -> None:
    assert str(off) == words


def test_the_robot_that_ended_farthest_off_comes_first() -> None:
    errors = Errors()
    for robot, last in (("a", Deviation(0.1, 0.2)), ("b", Deviation(0.3, 0.0)), ("c", Deviation(0.1, 0.3))):
        errors.robots[robot] = last, last
    assert [line.split()[0] for line in errors.lines()] == ["b", "c", "a"]


def test_the_worst_of_a_link_is_kept() -> None:
    errors = Errors()
    for error, lag in ((0.002, 0.05), (0.001, 0.2)):
        errors.take_link({"host": "pi", "error": error, "lag": lag})
    assert errors.links == {"pi": {"error": 0.002, "lag": 0.2}}


def test_a_fault_lasts_until_it_is_over() -> None:
    errors = Errors()
    began = {"robot": "r", "fault": "slips", "over": False, "worst": {"distance": 0.1}}
    errors.note({**began, "beat": 2.0})
    errors.note({**began, "robot": "s", "beat": 3.0})
    errors.note({**began, "over": True, "beat": 4.0, "worst": {"distance": 0.3}})
    assert errors.faults_as_json() == [
        {"robot": "r", "kind": "slips", "from": 2.0, "to": 4.0, "worst": {"distance": 0.3}},
        {"robot": "s", "kind": "slips", "from": 3.0, "to": None, "worst": {"distance": 0.1}},
    ]


def test_github_accepts_no_columns_of_a_place_on_several_lines() -> None:
    several = Diagnostic("empty-group", Span(1, 5), "50% is empty")
    assert as_annotation(Path("/a,b.improv"), LineIndex("abc\ndef"), several) == (
        "::warning title=empty-group,file=/a%2Cb.improv,line=1,endLine=2"
        "::/a,b.improv:1:2: warning[empty-group] 50%25 is empty"
    )
