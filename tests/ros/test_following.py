"""`follow` with a base whose wheels roll too little, seen from outside, and judged by its true pose."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest

from improv_core.score.motion import Pose
from tests.commands.command_line import IMPROV
from tests.ros.conftest import LIMIT, Listen, Script
from tests.ros.dance import still
from tests.ros.test_base import BASE, apart, last

PROGRAM = "beat 60\nanna $ repeat 4 (forward slow 2 left)\n"
ROBOTS = """
[robots.anna]
profile = "turtlebot4"
odom = "true_pose"
follow = true
"""
FAR, TURNED = 0.03, 2.0
"""Meters and degrees; without `follow`, it is 0.05 and 20."""


def test_a_square_on_a_base_that_drifts(
    script: Script, listen: Listen, ros_env: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script(BASE, "anna", "--wheel-error", "0.96", "0.94", "--noise", "0.01", "--loss", "0.05")
    true = listen("/anna/true_pose", "--pose", "--name", "anna_true")
    told = listen("/anna/cmd_vel", "--name", "anna_told")
    (tmp_path / "improv.toml").write_text(ROBOTS)
    (tmp_path / "dance.improv").write_text(PROGRAM)
    command = [*IMPROV, "play", "dance.improv", "--backend", "ros"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=ros_env, timeout=LIMIT)
    assert done.returncode == 0
    told.wait(lambda message: bool(message["x"]))
    for _ in range(3):
        told.wait(still)
    sent = told.heard
    off, turn = apart(last(true, sent[-1]["at"] + 1.0), Pose())
    with capsys.disabled():
        print(f"\nafter a square with `follow`: {off:.3f} m, {turn:.1f}°")
    assert off < FAR
    assert turn < TURNED
    # At most a tenth of the limits is added, and a robot that is to stand is not moved.
    assert any(message["x"] not in (0, 0.2) for message in sent)
    assert max(message["x"] for message in sent) <= 0.2 + 0.0306 + 1e-9
    assert max(message["yaw"] for message in sent) <= math.pi / 4 + 0.19 + 1e-9
    assert [(message["x"], message["yaw"]) for message in sent[-3:]] == [(0, 0)] * 3
