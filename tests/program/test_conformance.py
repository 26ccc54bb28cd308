"""Every program of the suites (of all words, of other keyboards, with measures, and with body parts) compiles to the
expected segments, and wrong ones have the expected codes and fixes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from improv_core.diagnostics import applied
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.program.script import read_script
from improv_core.robots.config import read_robots
from improv_core.score.score_json import from_json, to_json
from tests.ide.cursor import preferred

TESTS = Path(__file__).parent.parent
SUITES: list[dict[str, Any]] = [
    json.loads((TESTS / f"{name}.json").read_text("utf-8")) for name in ("conformance", "keyboards", "measures")
]
CASES: list[dict[str, Any]] = [case for suite in SUITES for case in suite["cases"]]
BODIES: dict[str, Any] = json.loads((TESTS / "bodies.json").read_text("utf-8"))


@cache  # each worker collects this file, and one runs it
def analyses() -> Mapping[str, Analysis]:
    return {case["program"]: analyze(case["program"]) for case in CASES}


def with_bodies(group: dict[str, Any], program: str) -> Analysis:
    analysis = analyze(program, read_robots(group["toml"]))
    assert analysis.config.diagnostics == ()
    return analysis


@cache
def bodies() -> Sequence[tuple[dict[str, Any], Analysis]]:
    return [
        (case, with_bodies(group, case["program"])) for group in (BODIES, BODIES["poses"]) for case in group["cases"]
    ]


def segments(case: dict[str, Any]) -> dict[str, list[Any]]:
    script = read_script(json.dumps(case.get("senses", [])))
    return {
        name: part["segments"] for name, part in compiled(analyses()[case["program"]], script=script)["robots"].items()
    }


def expected(robots: dict[str, list[Any]]) -> dict[str, list[Any]]:
    return {name: [pytest.approx(each, abs=1e-9) for each in robot] for name, robot in robots.items()}


def test_programs_compile_to_their_segments() -> None:
    wrong = [case["program"] for case in CASES if segments(case) != expected(case["robots"])]
    assert wrong == []
    assert all(list(segments(case)) == list(case["robots"]) for case in CASES), "robots keep their order"


def test_programs_compile_to_their_starts() -> None:
    said = [case for case in CASES if "start" in case]
    assert len(said) > 20
    for case in said:
        found = compiled(analyses()[case["program"]])
        starts = {name: part["start"] for name, part in found["robots"].items()}
        assert starts == {name: pytest.approx(start, abs=1e-9) for name, start in case["start"].items()}
        room = case.get("room")
        assert (found.get("bar"), found.get("room")) == (case.get("bar"), room and tuple(room))


def test_bases_and_joints_compile_to_their_segments() -> None:
    for case, analysis in bodies():
        robots = compiled(analysis)["robots"]
        bases = {name: robot["segments"] for name, robot in robots.items()}
        wanted = {name: robot.get("base", bases[name]) for name, robot in case["robots"].items()}
        assert bases == expected(wanted), case["program"]
        for name, robot in robots.items():
            assert robot["joints"] == expected(case["robots"][name]["joints"]), case["program"]
            assert set(robot["joints"]) <= set(robot["range"])


def test_errors_have_their_codes_and_preferred_fixes() -> None:
    for suite in SUITES[1:]:
        for case in suite["codes"]:
            assert case["code"] in [each.code for each in analyze(case["program"]).diagnostics], case["program"]
        for case in suite["fixes"]:
            [edits] = preferred(analyze(case["typed"]))
            assert applied(case["typed"], edits) == case["becomes"]


def test_errors_of_poses_have_their_codes() -> None:
    for case in BODIES["poses"]["errors"]:
        analysis = with_bodies(BODIES["poses"], case["program"])
        assert [each.code for each in analysis.diagnostics] == [case["code"]], case["program"]
        assert not analysis.ok


def test_scores_survive_json() -> None:
    for analysis in (*analyses().values(), *(analysis for _, analysis in bodies())):
        written = json.dumps(to_json(score_of(analysis)))
        assert json.dumps(to_json(from_json(json.loads(written)))) == written
