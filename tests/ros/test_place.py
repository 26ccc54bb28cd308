"""`improv place` with a simulated base that slips and whose poses are late, over ROS."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest

from tests.commands.command_line import IMPROV
from tests.ros.conftest import BASE, Script

pytestmark = pytest.mark.slow("a robot drives to its place, slowly")

TOML = """
[ros]
odom_frame = "world"
[profiles.base]
base = "turtlebot4"
max_linear = 1
max_angular = 2
[robots.ada]
profile = "base"
odom = "true_pose"
start = { x = 0, y = 0, heading = 0 }
"""


def test_a_base_that_slips_gets_to_its_place(script: Script, ros_env: dict[str, str], tmp_path: Path) -> None:
    """tests/commands/test_place.py tests several bases, and bases whose poses no longer come."""
    slips = ("--wheel-error", "0.97", "0.95", "--delay", "0.08")
    base = script(BASE, "ada", "--start", "-0.3", "0.2", "-1", *slips)
    (tmp_path / "improv.toml").write_text(TOML)
    (tmp_path / "dance.improv").write_text("ada $ forward\n")
    command = [*IMPROV, "place", "--yes", "--backend", "ros", "dance.improv"]
    placed = subprocess.run(command, cwd=tmp_path, env=ros_env, capture_output=True, text=True, timeout=300)
    assert placed.returncode == 0, placed.stdout + placed.stderr
    x, y, heading = map(float, base.communicate()[0].split())
    assert math.hypot(x, y) <= 0.05
    assert abs(math.remainder(heading, math.tau)) <= math.radians(5)
