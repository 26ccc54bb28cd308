"""The Python with which a session starts its stage of real robots."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any

import pytest

from improv_core.ipc.stage_process import Stage, StageError
from improv_core.outputs.ros.setup.interpreter import Interpreter, InterpreterError
from improv_core.safety.stops import Stops
from improv_core.session import start
from improv_core.session.start import Options


def check(
    monkeypatch: pytest.MonkeyPatch,
    likely: str,
    proven: str | None,
    works: Sequence[str],
    started: str,
    problem: str = "",
) -> None:
    """Start a stage: `likely` comes first, and proofs find another Python, none, or a problem. Only some `works`."""
    tried = []

    def find(setting: str | None, *, proves: bool) -> Interpreter | None:
        if proves and problem:
            raise InterpreterError(problem)
        python = proven if proves else likely
        return Interpreter(python, {}, "") if python else None

    async def start_process(command: Sequence[str], *rest: Any) -> str:
        tried.append(command[0])
        if command[0] not in works:
            raise StageError(f"{command[0]} fails")
        return command[0]

    monkeypatch.setattr(Stage, "start", start_process)
    options = Options("auto", find_python=find)
    try:
        stage: Any = asyncio.run(start.start_stage("ros", options, "", lambda *_: None, Stops()))
    except StageError as error:
        stage = str(error)
    assert f"{' '.join(tried)}: {stage}" == started


def test_a_python_that_works_needs_no_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch, "one", None, ["one"], "one: one", problem="a proof was asked for")


def test_if_the_likeliest_python_fails_another_one_is_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch, "one", "two", ["two"], "one two: two")
    check(monkeypatch, "one", None, [], "one: None")


def test_the_reason_of_a_failure_is_the_best_that_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch, "one", "one", [], "one: one fails")
    check(monkeypatch, "one", None, [], "one: one lacks rclpy", problem="one lacks rclpy")
