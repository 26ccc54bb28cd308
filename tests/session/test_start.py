"""A child Python imports nothing from the current folder."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from pathlib import Path

import pytest

from improv_core.ipc.child import ROOT, isolated
from improv_core.safety.stops import Stops
from improv_core.session.start import Options, start_stage
from tests.traps import MODULES, PYTHONPATHS, Traps


@pytest.fixture
def traps(tmp_path: Path) -> Traps:
    return Traps(tmp_path)


def test_the_traps_work(traps: Traps) -> None:
    script = "; ".join(f"import {name}" for name in MODULES)
    subprocess.run([sys.executable, "-c", script], cwd=traps.folder, check=True)
    assert set(traps.imported) >= {"venv", "pip", "rclpy", "json"}


def start_and_stop_a_stage() -> None:
    async def start_and_stop() -> None:
        stage = await start_stage("simulator", Options(), "token", lambda stage, heard, asked: None, Stops())
        assert stage
        await stage.close()

    asyncio.run(start_and_stop())


@pytest.mark.parametrize("pythonpath", PYTHONPATHS)
def test_a_stage_imports_nothing_from_a_project(traps: Traps, monkeypatch: pytest.MonkeyPatch, pythonpath: str) -> None:
    traps.enter(monkeypatch, pythonpath)
    start_and_stop_a_stage()
    assert traps.imported == []


def test_a_stage_is_of_the_version_that_started_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "improv_core").mkdir()
    (tmp_path / "improv_core" / "__init__.py").write_text("raise SystemExit('another version')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    start_and_stop_a_stage()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (None, None),
        ("", None),
        (":", None),
        (".:lib:../lib:~/lib", None),
        ("/opt/ros/lib", "/opt/ros/lib"),
        (":/opt/ros/lib::.:/opt/own/lib:", "/opt/ros/lib:/opt/own/lib"),
    ],
)
def test_the_pythonpath_of_a_sourced_ros_stays(before: str | None, after: str | None) -> None:
    env = {"HOME": "/home/anna"} | ({} if before is None else {"PYTHONPATH": before})
    expected = {"HOME": "/home/anna"} | ({} if after is None else {"PYTHONPATH": after})
    assert (isolated(env), ROOT) == (expected, "/")
