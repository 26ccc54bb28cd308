"""`improv place` with simulated bases that slip and are seen late, over ROS."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest

from improv_core.commands.exit_codes import FAILED
from tests.commands.command_line import IMPROV
from tests.ros.conftest import BASE, Script

pytestmark = pytest.mark.slow("robots drive to their places, slowly")

TOML = """
[ros]
odom_frame = "world"
[profiles.base]
base = "turtlebot4"
max_linear = 1
max_angular = 2
"""
ROBOT = """
[robots.{name}]
profile = "base"
odom = "true_pose"
start = {{ x = 0, y = {y}, heading = 0 }}
"""
SLIPS = ("--wheel-error", "0.97", "0.95", "--delay", "0.08")


def place(folder: Path, env: dict[str, str], **places: float) -> subprocess.CompletedProcess[str]:
    """Drive robots to their places along the y axis."""
    toml = TOML + "".join(ROBOT.format(name=name, y=y) for name, y in places.items())
    (folder / "improv.toml").write_text(toml)
    (folder / "dance.improv").write_text(f"{' '.join(places)} $ forward\n")
    command = [*IMPROV, "place", "--yes", "--backend", "ros", "dance.improv"]
    return subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, timeout=300, check=False)


def where(base: subprocess.Popen[str]) -> tuple[float, float, float]:
    """Where a base really is in the end."""
    x, y, heading = map(float, base.communicate()[0].split())
    return x, y, heading


def test_bases_that_slip_get_to_their_places(script: Script, ros_env: dict[str, str], tmp_path: Path) -> None:
    starts = {"ada": ("0.5", "0.2", "2"), "ben": ("-0.3", "1.3", "-1")}
    bases = {name: script(BASE, name, "--start", *start, *SLIPS) for name, start in starts.items()}
    placed = place(tmp_path, ros_env, ada=0, ben=1)
    assert placed.returncode == 0, placed.stdout + placed.stderr
    for (name, base), y in zip(bases.items(), (0, 1), strict=True):
        x, really, heading = where(base)
        assert math.hypot(x, really - y) <= 0.05, name
        assert abs(math.remainder(heading, math.tau)) <= math.radians(5), name


def test_a_base_that_is_no_longer_seen_stands(script: Script, ros_env: dict[str, str], tmp_path: Path) -> None:
    base = script(BASE, "ada", "--start", "3", "0", "0", *SLIPS, "--seen", "3")
    placed = place(tmp_path, ros_env, ada=0)
    assert placed.returncode == FAILED
    assert "paused: a pose of ada didn't come for 0.2 s" in placed.stderr
    assert "no pose came for 5 s: start what publishes them, then place robots again" in placed.stderr
    x, y, _ = where(base)
    assert math.hypot(x, y) > 1, "it drove on blindly"
