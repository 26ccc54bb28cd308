"""`improv edit` with real robots and no simulator: its page plays, shows, and stops them, even if nobody helps it."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.open_page import connected, heard, live_behind, stop_by
from tests.processes import descendants, halt, wait_until_gone
from tests.ros.conftest import LIMIT, Listen, Listener
from tests.ros.dance import BEFORE, BEFORE_SPEED, at_speed, still

pytestmark = pytest.mark.slow("starts what plays, and a base that listens in ROS 2")


def test_a_page_without_a_simulator_plays_shows_and_stops_real_robots(
    listen: Listen, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    robot = listen("/turtle1/cmd_vel")
    file = tmp_path / "dance.improv"
    file.write_text("")
    command = [sys.executable, "-m", "improv_core", "edit", str(file), "--backend", "ros", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=ros_env, text=True) as edit:
        assert edit.stdout
        url = next(line.split()[-1] for line in edit.stdout if "http://" in line)
        asyncio.run(play_and_stop(live_behind(url), robot, edit.pid))
        started = descendants(edit.pid)
        edit.terminate()
    wait_until_gone(started, LIMIT)
    assert file.read_text() == BEFORE


async def play_and_stop(live: str, robot: Listener, session: int) -> None:
    async with connected(f"{live}&page=abcdefghijklmnop") as page:
        source = await heard(page, lambda told: told["type"] == "source")
        await page.send_json({"type": "write", "number": 1, "text": BEFORE, "revision": source["revision"]})
        await heard(page, lambda told: told["type"] == "score" and told["robots"])
        await heard(page, lambda told: told["type"] == "poses" and told["poses"][0][0] > 0.1)
        await asyncio.to_thread(robot.wait, at_speed(BEFORE_SPEED))
        halt(session)
        status, _ = await asyncio.to_thread(stop_by, live)
        assert status == 204
        await asyncio.to_thread(robot.wait, still)
        os.kill(session, signal.SIGCONT)
        await heard(page, lambda told: told["type"] == "transport" and told["state"] == "stopped")
