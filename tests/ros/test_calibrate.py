"""`improv calibrate` with a base whose poses come over ROS."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.commands.command_line import IMPROV
from tests.ros.conftest import BASE, Script, with_limits

pytestmark = pytest.mark.slow("a robot drives the distances that are measured")

ROBOTS = """
[profiles.base]
base = "turtlebot4"
max_linear = 1
max_angular = 4

[robots.anna]
profile = "base"
odom = "odom"
odom_frame = "{frame}"
"""


COMMAND = [*IMPROV, "calibrate", "anna", "--backend", "ros", "--tempo", "120", "--write"]


LATE = "the dance was stopped, so nothing was measured: start again"
OWN = "the poses of anna on /anna/odom are nav_msgs/Odometry: a base's own odometry counts"


@pytest.mark.parametrize(
    ("frame", "expected", "last"),
    [
        ("own", [LATE, OWN], "Put anna on its mark"),
        ("world", [LATE], "Press Enter: anna turns left on the spot, twice"),
    ],
)
def test_a_robot_that_comes_late_is_measured_unless_it_has_only_wheel_odometry(
    frame: str, expected: list[str], last: str, script: Script, ros_env: dict[str, str], tmp_path: Path
) -> None:
    """Neither its place nor the frame of its poses matters.

    tests/commands/test_calibrate.py and tests/routines/test_calibration.py test the use of the measurements.
    """
    toml = ROBOTS.format(frame=frame)
    (tmp_path / "improv.toml").write_text(toml)
    pipe = subprocess.PIPE
    soon = with_limits(player__subscribers__PATIENCE=0.5, outputs__ros__sensors__client__FIND_LIMIT=0.5)
    said: list[str] = []
    with subprocess.Popen(
        COMMAND,
        stdin=pipe,
        stdout=pipe,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=tmp_path,
        env={**ros_env, **soon},
    ) as process:
        assert process.stdin
        assert process.stdout
        process.stdin.write("0.2\n")
        process.stdin.flush()
        is_there = False
        for line in process.stdout:
            said.append(line)
            if LATE in line and not is_there:
                script(BASE, "anna", "--noise", "0", "--loss", "0", "--start", "1", "0", "0")
                is_there = True
            if last in line:
                process.stdin.close()
            elif "Enter" in line:
                process.stdin.write("\n")
                process.stdin.flush()
    whole = "".join(said)
    assert "nothing is listening on /anna/cmd_vel" in whole
    for line in expected:
        assert line in whole
    assert whole.endswith("improv: no answer: nothing was changed\n")
    assert process.returncode == 2
    assert (tmp_path / "improv.toml").read_text() == toml
