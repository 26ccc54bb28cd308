"""Every program of the conformance suite with body parts compiles to the expected segments."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.robots.config import read_robots
from improv_core.score.score_json import from_json, to_json

SUITE: dict[str, Any] = json.loads((Path(__file__).parent.parent / "bodies.json").read_text())
GROUPS = [SUITE, SUITE["poses"]]


def analyzed(group: dict[str, Any], program: str) -> Analysis:
    analysis = analyze(program, read_robots(group["toml"]))
    assert analysis.config.diagnostics == ()
    return analysis


CASES = [(case, analyzed(group, case["program"])) for group in GROUPS for case in group["cases"]]


def test_bases_compile_to_their_segments() -> None:
    for case, analysis in CASES:
        found = {name: robot["segments"] for name, robot in compiled(analysis)["robots"].items()}
        expected = {name: robot.get("base", found[name]) for name, robot in case["robots"].items()}
        approximate = {name: [pytest.approx(each, abs=1e-9) for each in robot] for name, robot in expected.items()}
        assert found == approximate, case["program"]


def test_joints_compile_to_their_segments() -> None:
    for case, analysis in CASES:
        for name, robot in compiled(analysis)["robots"].items():
            expected = case["robots"][name]["joints"]
            found = robot["joints"]
            assert found == {
                joint: [pytest.approx(each, abs=1e-9) for each in stretches] for joint, stretches in expected.items()
            }, case["program"]
            assert set(found) <= set(robot["range"])


def test_errors_have_their_codes() -> None:
    for case in SUITE["poses"]["errors"]:
        analysis = analyzed(SUITE["poses"], case["program"])
        assert [each.code for each in analysis.diagnostics] == [case["code"]], case["program"]
        assert not analysis.ok


def test_scores_with_bodies_survive_json() -> None:
    for _, analysis in CASES:
        written = json.dumps(to_json(score_of(analysis)))
        assert json.dumps(to_json(from_json(json.loads(written)))) == written
