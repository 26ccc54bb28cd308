"""`improv calibrate` with a base whose wheels roll too little, measured by its true pose."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from improv_core.robots.config import read_robots
from tests.commands.command_line import IMPROV
from tests.ros.conftest import LIMIT, Script
from tests.ros.test_base import BASE

ROBOTS = """
[profiles.base]
base = "turtlebot4"
max_linear = 1
max_angular = 4

[robots.anna]
profile = "base"
odom = "{topic}"
"""


COMMAND = [*IMPROV, "calibrate", "anna", "--backend", "ros", "--tempo", "120", "--write"]


def test_a_base_keeps_to_its_path_afterward(
    script: Script, ros_env: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script(BASE, "anna", "--wheel-error", "0.96", "0.94", "--noise", "0.01", "--loss", "0")
    (tmp_path / "improv.toml").write_text(ROBOTS.format(topic="true_pose"))
    answers = "1.05\n" + 20 * "\n"  # room for five steps, and Enter each time
    done = subprocess.run(
        COMMAND, input=answers, capture_output=True, text=True, cwd=tmp_path, env=ros_env, timeout=2 * LIMIT
    )
    assert done.returncode == 0
    found = re.findall(r"(?:before|after): +([\d.]+) m .*?, ([\d.]+)° to the .*?; ([\d.]+)°", done.stdout)
    errors = [(abs(float(meters) - 1), float(bend), abs(float(turn) - 720)) for meters, bend, turn in found]
    with capsys.disabled():
        print(f"\nerrors before and after calibration, in m, °, and °: {errors}")
    (before, after) = errors
    assert all(new < old / 2 for old, new in zip(before, after, strict=True))
    profile = read_robots((tmp_path / "improv.toml").read_text()).robots["anna"].profile
    assert profile.step == 0.2
    assert profile.linear_scale == pytest.approx(1 / 0.95, rel=0.02)
    assert profile.left_right == pytest.approx(0.96 / 0.94, abs=0.01)


def test_a_robot_that_is_not_there_and_odometry_that_counts_turns_of_wheels(
    script: Script, ros_env: dict[str, str], tmp_path: Path
) -> None:
    (tmp_path / "improv.toml").write_text(ROBOTS.format(topic="odom"))
    pipe = subprocess.PIPE
    said: list[str] = []
    with subprocess.Popen(
        COMMAND, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, text=True, cwd=tmp_path, env=ros_env
    ) as process:
        assert process.stdin
        assert process.stdout
        process.stdin.write("0.2\n")
        process.stdin.flush()
        for line in process.stdout:
            said.append(line)
            if "didn't arrive" in line and "didn't arrive" not in "".join(said[:-1]):
                script(BASE, "anna")
            if "Press Enter" in line:
                process.stdin.write("\n")
                process.stdin.flush()
            if "on its mark" in line:
                process.stdin.close()
    whole = "".join(said)
    assert "nothing is listening on /anna/cmd_vel" in whole
    assert "the poses of anna on /anna/odom didn't arrive: check their publisher, or use `--tape`" in whole
    assert "the poses of anna on /anna/odom are nav_msgs/Odometry: a base's own odometry counts" in whole
    assert whole.endswith("improv: nobody answers: nothing was changed\n")
    assert process.returncode == 2
    assert (tmp_path / "improv.toml").read_text() == ROBOTS.format(topic="odom")
