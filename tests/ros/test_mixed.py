"""A Thymio and a robot of ROS 2 dance as one: the simulator of Thymio's makers, and a real subscriber."""

from __future__ import annotations

import os
import queue
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from improv_core.outputs.thymio.bus import Bus
from improv_core.safety.allowed import approve
from tests.commands.command_line import stop_within
from tests.outputs.playground import LIMIT, playground
from tests.ros.conftest import Listen
from tests.ros.dance import Terminal, still

BEAT = 2.0
"""Seconds. A busy machine simulates a Thymio late, and that reports ten times a second."""
TOML = """
[robots.ada]
output = "thymio"
address = "{}"
profile = "small"
[robots.r]
profile = "small"
[profiles.small]
base = "thymio2"
"""
PROGRAM = f"beat {60 / BEAT:g}\nada r $ repeat (forward backward)\n"


@pytest.mark.slow("starts a simulator, and a stage for each output")
def test_both_play_on_the_beat_until_one_stop(
    listen: Listen, alone: Mapping[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    env = {**alone, "XDG_CONFIG_HOME": str(tmp_path / "config")}
    robot, targets = listen("/r/cmd_vel"), queue.SimpleQueue[tuple[float, int]]()

    def turn(*others: int) -> tuple[float, int]:
        """Wait until the Thymio drives in none of these directions (0: it stands). Return when, and the direction."""
        while True:
            at, target = targets.get(timeout=LIMIT)
            if (sign := (target > 0) - (target < 0)) not in others:
                return at, sign

    with playground(tmp_path, {"ada": (150, 150)}) as address:
        approve(address)
        (tmp_path / "improv.toml").write_text(TOML.format(address))
        with Terminal("play", tmp_path / "dance.improv", env, PROGRAM):
            bus = Bus.join(address)
            bus.listen(bus.find("", 1), lambda words: targets.put((time.monotonic(), words[4])))
            direction, apart = 0, list[float]()
            for _ in range(4):
                at, direction = turn(direction, 0)  # it stands if its stage is late
                heard = robot.wait(lambda message, sign=direction: message["x"] * sign > 0)  # type: ignore[misc]
                apart.append(abs(heard["at"] - at))
            assert min(apart) < BEAT / 2, "whoever hears them may be late once"
            subprocess.run(stop_within(os.environ["XDG_RUNTIME_DIR"]), env=env, check=True)
            turn(1, -1)
            robot.wait(still)
