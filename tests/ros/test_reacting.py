"""Robots that react to real sensors: a subscriber's messages when scans change or stop."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from pathlib import Path
from typing import Any

import pytest

from improv_core.commands.terminal import performance
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from improv_core.session.start import Options
from tests.ros.conftest import LIMIT, Listen, Listener, Publish, be_patient, scan

pytestmark = pytest.mark.slow("starts a stage, and a sensor falls silent")

CMD = "/anna/cmd_vel"
ROBOTS = """
[senses.near]
topic = "scan"
message = "sensor_msgs/LaserScan"
below = 0.5
from = -30
to = 30
"""
FAR, CLOSE = scan(3.0), scan(0.4)
Message = Mapping[str, Any]


def goes(message: Message) -> bool:
    return bool(message["x"] > 0)


def turns(message: Message) -> bool:
    return bool(message["x"] == 0 and message["yaw"] > 0)


def stands(message: Message) -> bool:
    return not (message["x"] or message["yaw"])


Wait = Callable[[Callable[[Message], bool]], Coroutine[Any, Any, Any]]
"""A call that waits for a command that fits."""


@pytest.fixture
def robot(listen: Listen, ros_env: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Listener:
    for name, value in ros_env.items():
        monkeypatch.setenv(name, value)
    be_patient(monkeypatch)
    return listen(CMD)


def check(robot: Listener, python: str, program: str, then: Callable[[Wait], Coroutine[Any, Any, None]]) -> None:
    """Do this while a program plays, and check that the robot stands in the end."""

    async def wait(fits: Callable[[Message], bool]) -> None:
        await asyncio.to_thread(robot.wait, fits)

    async def perform() -> None:
        async with performance(Options("ros", 0, python), browser=False) as performing:
            analysis = analyze(program, read_robots(ROBOTS, Path("improv.toml")))
            assert analysis.ok
            await performing.play(analysis, Path("dance"))
            await then(wait)
        await wait(stands)

    asyncio.run(asyncio.wait_for(perform(), LIMIT))


ROAMER = "anna $ repeat (until near (repeat forward) until not near (repeat left))\n"


def test_a_robot_turns_where_something_is_near_and_stands_while_its_sensor_is_silent(
    robot: Listener, publish: Publish, ros_python: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A line also says why. tests/player/test_reacting.py tests the effects and their times."""
    scanner = publish("/anna/scan", "sensor_msgs/LaserScan", best_effort=True)
    scanner(FAR)

    async def react(wait: Wait) -> None:
        await wait(goes)
        scanner(CLOSE)
        await wait(turns)
        scanner(FAR)
        await wait(goes)
        scanner(None)
        await wait(stands)
        said = ""
        while "/anna/scan" not in said:
            await asyncio.sleep(0.01)
            said += capsys.readouterr().err
        assert "anna stands still where it reads `near`" in said
        scanner(FAR)
        await wait(goes)

    check(robot, ros_python, ROAMER, react)
