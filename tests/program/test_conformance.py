"""Every program of the conformance suite compiles to what it must."""

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


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["program"])
def test_program_compiles_to_its_segments(case: dict[str, Any]) -> None:
    script = read_script(json.dumps(case.get("senses", [])))
    robots = compiled(analyze(case["program"]), script=script)["robots"]
    assert list(robots) == list(case["robots"])
    for name, expected in case["robots"].items():
        segments = robots[name]["segments"]
        assert len(segments) == len(expected)
        for segment, wanted in zip(segments, expected, strict=True):
            assert segment == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["program"])
def test_score_survives_its_way_to_the_stage(case: dict[str, Any]) -> None:
    score = score_of(analyze(case["program"]))
    written = json.dumps(to_json(score))
    assert json.dumps(to_json(from_json(json.loads(written)))) == written
