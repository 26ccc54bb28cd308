"""Robots that react to real sensors: a subscriber's messages when scans change or stop."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.ros.conftest import Listen, Publish, scan
from tests.ros.dance import Terminal, still

pytestmark = pytest.mark.slow("starts a stage, and a sensor falls silent")

ROBOTS = """
[senses.near]
topic = "scan"
message = "sensor_msgs/LaserScan"
below = 0.5
from = -30
to = 30
"""
ROAMER = "anna $ repeat (until near (repeat forward) until not near (repeat left))\n"
FAR, CLOSE = scan(3.0), scan(0.4)


def goes(message: Mapping[str, Any]) -> bool:
    return bool(message["x"] > 0)


def turns(message: Mapping[str, Any]) -> bool:
    return bool(message["x"] == 0 and message["yaw"] > 0)


def test_a_robot_turns_where_something_is_near_and_stands_while_its_sensor_is_silent(
    listen: Listen, publish: Publish, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """A line also says why. tests/player/test_reacting.py tests the effects and their times."""
    (tmp_path / "improv.toml").write_text(ROBOTS)
    robot = listen("/anna/cmd_vel")
    scanner = publish("/anna/scan", "sensor_msgs/LaserScan", best_effort=True)
    scanner(FAR)
    with Terminal("play", tmp_path / "dance.improv", ros_env, ROAMER) as dance:
        robot.wait(goes)
        scanner(CLOSE)
        robot.wait(turns)
        scanner(FAR)
        robot.wait(goes)
        scanner(None)
        robot.wait(still)
        dance.wait_for_line("anna stands still where it reads `near`")
        scanner(FAR)
        robot.wait(goes)
        dance.process.terminate()
        robot.wait(still)
