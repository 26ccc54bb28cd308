"""Robots that react to real sensors: what a subscriber hears when scans change, stop, come late, or their node dies."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from pathlib import Path
from typing import Any

import pytest

from improv_core.commands.terminal import Performance, performance
from improv_core.playback.start import Options
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from tests.ros.conftest import LIMIT, Listen, Listener, Sense, scan

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
"""Waits for a command that fits."""


@pytest.fixture
def robot(listen: Listen, ros_env: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> Listener:
    for name, value in ros_env.items():
        monkeypatch.setenv(name, value)
    return listen(CMD)


def check(
    robot: Listener, python: str, program: str, then: Callable[[Wait, Performance], Coroutine[Any, Any, None]]
) -> None:
    """While a program plays, do this. In the end, the robot stands."""

    async def wait(fits: Callable[[Message], bool]) -> None:
        await asyncio.to_thread(robot.wait, fits)

    async def perform() -> None:
        async with performance(Options("ros", 0, python), browser=False) as performing:
            analysis = analyze(program, read_robots(ROBOTS, Path("improv.toml")))
            assert analysis.ok
            await performing.play(analysis, Path("dance"))
            await then(wait, performing)
        await wait(stands)

    asyncio.run(asyncio.wait_for(perform(), LIMIT))


ROAMER = "anna $ repeat (until near (repeat forward) until not near (repeat left))\n"


def test_a_robot_turns_where_something_is_near(robot: Listener, sensor: Sense, ros_python: str) -> None:
    scanner = sensor("/anna/scan", "sensor_msgs/LaserScan")
    scanner(FAR)

    async def react(wait: Wait, performing: Performance) -> None:
        await wait(goes)
        scanner(CLOSE)
        await wait(stands)
        await wait(turns)
        scanner(FAR)
        await wait(stands)
        await wait(goes)

    check(robot, ros_python, ROAMER, react)


def test_a_robot_whose_sensor_falls_silent_stands_until_it_is_back(
    robot: Listener, sensor: Sense, ros_python: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scanner = sensor("/anna/scan", "sensor_msgs/LaserScan")
    scanner(FAR)

    async def fall_silent(wait: Wait, performing: Performance) -> None:
        await wait(goes)
        scanner(None)
        await wait(stands)
        scanner(FAR)
        await wait(goes)

    check(robot, ros_python, ROAMER, fall_silent)


def test_a_robot_whose_sensor_dies_stands_and_a_line_says_why(
    robot: Listener, sensor: Sense, ros_python: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scanner = sensor("/anna/scan", "sensor_msgs/LaserScan")
    scanner(FAR)

    async def die(wait: Wait, performing: Performance) -> None:
        await wait(goes)
        scanner.process.kill()
        await wait(stands)
        said = ""
        while "/anna/scan" not in said:
            await wait(stands)
            said += capsys.readouterr().err
        assert "anna stands still where it reads `near`" in said

    check(robot, ros_python, ROAMER, die)


def test_a_sensor_may_come_late(robot: Listener, sensor: Sense, ros_python: str) -> None:
    async def come(wait: Wait, performing: Performance) -> None:
        await wait(stands)
        scanner = sensor("/anna/scan", "sensor_msgs/LaserScan")
        scanner(FAR)
        await wait(goes)

    check(robot, ros_python, ROAMER, come)


def test_the_cue_goes_to_real_robots(robot: Listener, ros_python: str) -> None:
    async def wait_for_it(wait: Wait, performing: Performance) -> None:
        await wait(goes)
        performing.cue()
        await wait(stands)
        await wait(turns)

    check(robot, ros_python, "anna $ until cue (repeat forward) repeat 60 left\n", wait_for_it)
