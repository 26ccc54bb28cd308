"""ROS's Python imports nothing from the current folder: not the probe, the stage, its standby, or the doctor's look."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from improv_core.commands.doctor_ros import examine_ros
from improv_core.commands.finding import BROKEN, GOOD
from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.safety.stops import Stops
from improv_core.score.score import Safety
from improv_core.session.start import Options, start_stage
from tests.processes import ours, wait_until_gone
from tests.ros.conftest import LIMIT
from tests.traps import PYTHONPATHS, Traps

pytestmark = pytest.mark.slow("starts a stage and its standby")


@pytest.fixture
def traps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros_env: dict[str, str]) -> Traps:
    for name, value in ros_env.items():
        monkeypatch.setenv(name, value)
    traps = Traps(tmp_path)
    traps.enter(monkeypatch, PYTHONPATHS[-1])
    return traps


def folder(pid: int) -> Path:
    """Return the working directory of a process."""
    return Path(f"/proc/{pid}/cwd").readlink()


def test_the_stage_and_its_standby_import_nothing_from_the_folder(traps: Traps) -> None:
    async def start_and_stop() -> None:
        stage = await start_stage(
            "ros", Options(find_python=find_ros_python), "token", lambda stage, heard, asked: None, Stops()
        )
        assert stage
        processes = ours("improv_core/stage\0")
        assert len(processes) == 2
        assert set(map(folder, processes)) == {Path("/")}
        await stage.close()
        wait_until_gone(processes, LIMIT)

    asyncio.run(start_and_stop())
    assert traps.imported == []


def test_the_doctor_imports_nothing_from_the_folder(traps: Traps, monkeypatch: pytest.MonkeyPatch) -> None:
    """It also looks with a ROS that doesn't start."""
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    found, reach, looked = examine_ros({}, Safety(), [], {})
    assert (found.mark, reach.mark, looked.mark) == (GOOD, GOOD, BROKEN)
    assert looked.what.startswith("ROS 2 does not start (")
    assert traps.imported == []
