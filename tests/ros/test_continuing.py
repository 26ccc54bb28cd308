"""Saves to one robot's line while another dances on, as a real subscriber hears it and as a recording has it."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from improv_core.commands.terminal import performance
from improv_core.playback.start import Options
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from improv_core.stage.setpoints import LAST_ZEROS
from tests.edited_dance import ANNA, BERT, play, record_undisturbed
from tests.recordings import Velocity, read
from tests.ros.conftest import Listen
from tests.ros.dance import still

BEATS, SAVES = 40, 40


def of(path: Path, topic: str) -> list[Velocity]:
    return [message.velocity for message in read(path) if message.topic == topic]


def changes(commands: Sequence[Velocity]) -> list[Velocity]:
    return [velocity for velocity, _ in groupby(commands)]


def is_within(some: Sequence[Velocity], commands: Sequence[Velocity]) -> bool:
    """Whether nothing was added and nothing is in another order. A busy machine may leave out repeats."""
    rest = iter(commands)
    return all(command in rest for command in some)


def test_a_robot_whose_line_is_not_edited_is_told_what_it_would_be_told_anyway(
    listen: Listen, ros_python: str, ros_env: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in ros_env.items():
        monkeypatch.setenv(name, value)
    anna, bert = listen(ANNA), listen(BERT)
    alone, edited = tmp_path / "alone.mcap", tmp_path / "edited.mcap"
    record_undisturbed(BEATS, alone)
    commands = of(alone, ANNA)

    async def next_command() -> None:
        await asyncio.to_thread(anna.wait, lambda message: True)

    asyncio.run(play(BEATS, SAVES, edited, Options("ros", 0, ros_python, report_sent=True), next_command))
    for _ in range(LAST_ZEROS):
        anna.wait(still)
    heard = [(each["x"], each["y"], each["z"], each["yaw"]) for each in anna.heard]
    assert of(edited, ANNA) == heard
    assert is_within(heard, commands)
    assert changes(heard) == changes(commands)
    bert.wait(lambda message: message["x"] > 0)
    assert len(set(of(edited, BERT))) > 10  # while bert's part did change


def test_a_robot_with_another_topic_is_stopped_on_the_old_one(
    listen: Listen, ros_python: str, ros_env: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in ros_env.items():
        monkeypatch.setenv(name, value)
    old, new = listen(BERT), listen("/other/cmd_vel")
    text = "anna $ repeat left\nbert $ repeat forward\n"

    async def perform() -> None:
        async with performance(Options("ros", 0, ros_python), browser=False, quiet=True) as performing:
            await performing.play(analyze(text), Path("dance"))
            await asyncio.to_thread(old.wait, moves)
            other = read_robots('[robots.bert]\ntopic = "/other/cmd_vel"\n')
            await performing.play(analyze(text, other), Path("dance"), when="beat")
            await asyncio.to_thread(new.wait, moves)
            for _ in range(LAST_ZEROS):
                await asyncio.to_thread(old.wait, still)
            await asyncio.to_thread(new.wait, moves)

    asyncio.run(perform())
    assert all(map(still, old.heard[-LAST_ZEROS:]))
    assert all(map(moves, old.heard[:-LAST_ZEROS]))


def moves(message: Mapping[str, Any]) -> bool:
    return not still(message)
