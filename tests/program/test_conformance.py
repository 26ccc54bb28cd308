"""Every program of the conformance suite compiles to the expected segments."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.program.script import read_script
from improv_core.score.score_json import from_json, to_json

CASES: list[dict[str, Any]] = json.loads((Path(__file__).parent.parent / "conformance.json").read_text())["cases"]
ANALYSES = {case["program"]: analyze(case["program"]) for case in CASES}


def segments(case: dict[str, Any]) -> dict[str, list[Any]]:
    script = read_script(json.dumps(case.get("senses", [])))
    return {
        name: part["segments"] for name, part in compiled(ANALYSES[case["program"]], script=script)["robots"].items()
    }


def expected(case: dict[str, Any]) -> dict[str, list[Any]]:
    return {name: [pytest.approx(each, abs=1e-9) for each in robot] for name, robot in case["robots"].items()}


def test_programs_compile_to_their_segments() -> None:
    wrong = [case["program"] for case in CASES if segments(case) != expected(case)]
    assert wrong == []
    assert all(list(segments(case)) == list(case["robots"]) for case in CASES), "robots keep their order"


def test_programs_compile_to_their_starts() -> None:
    said = [case for case in CASES if "start" in case]
    assert len(said) > 20
    for case in said:
        found = compiled(ANALYSES[case["program"]])
        starts = {name: part["start"] for name, part in found["robots"].items()}
        assert starts == {name: pytest.approx(start, abs=1e-9) for name, start in case["start"].items()}
        room = case.get("room")
        assert (found.get("bar"), found.get("room")) == (case.get("bar"), room and tuple(room))


def test_scores_survive_json() -> None:
    written = {program: json.dumps(to_json(score_of(analysis))) for program, analysis in ANALYSES.items()}
    assert {program: json.dumps(to_json(from_json(json.loads(score)))) for program, score in written.items()} == written
