"""Robots that are not in their places don't begin, over ROS: from a base's real pose to its first command."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from improv_core.commands.exit_codes import FAILED
from tests.ros.conftest import BASE, Script

pytestmark = pytest.mark.slow("processes of ROS find each other")

ROBOTS = """
[ros]
odom_frame = "world"
[robots.ada]
profile = "turtlebot4"
odom = "true_pose"
"""
WRONG = ("--start", "0.18", "-0.3118", "-0.0873", "--noise", "0", "--loss", "0")
"""Options that place the base 0.36 m from its start."""


def test_a_robot_that_was_placed_wrong_begins_only_if_forced(
    script: Script, ros_env: dict[str, str], tmp_path: Path
) -> None:
    script(BASE, "ada", *WRONG)
    (tmp_path / "improv.toml").write_text(ROBOTS)
    (tmp_path / "dance.improv").write_text("beat 60\nada $ forward repeat 2 rest\n")
    command = [sys.executable, "-m", "improv_core", "play", "--backend", "ros", "dance.improv", "--report", "json"]

    def play(*options: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*command, *options], cwd=tmp_path, env=ros_env, capture_output=True, text=True, timeout=90, check=False
        )

    refused = play()
    for _ in range(5):  # on a busy machine, the first poses may come after beat 0 has waited for them
        if "nobody knows" not in refused.stderr:
            break
        refused = play()
    assert refused.returncode == FAILED
    assert "doesn't begin: move ada 0.36 m toward 120° and turn it 5° left" in refused.stderr
    assert json.loads(refused.stdout)["misplaced"]["ada"]["line"] == "move ada 0.36 m toward 120° and turn it 5° left"
    forced = play("--force")
    assert forced.returncode == 0, forced.stderr
    off = json.loads(forced.stdout)["measured"]["ada"]["last"]
    assert 0.3 < off["distance"] < 0.45, "it is not laid on its start"
