"""A Thymio and a robot of ROS 2 dance as one: the simulator of Thymio's makers, and a real subscriber."""

from __future__ import annotations

import os
import queue
import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.thymio.bus import Bus
from improv_core.safety.allowed import approve
from tests.commands.command_line import stop_within
from tests.outputs.playground import LIMIT, playground
from tests.ros.conftest import Listen, Listener
from tests.ros.dance import Terminal, moving, still

pytestmark = pytest.mark.slow("starts a simulator, and a stage for each output")

BEAT = 2.0
"""Seconds. A busy machine simulates a Thymio late, and that reports ten times a second."""
TOML = """
[robots.ada]
output = "thymio"
address = "{address}"
profile = "small"
[robots.r]
profile = "small"
[profiles.small]
base = "thymio2"
[on]
gone = "{gone}"
"""


class Mixed:
    """The two robots, which drive forward and backward, and the process that plays."""

    def __init__(self, listener: Listener, env: Mapping[str, str], folder: Path, stack: ExitStack) -> None:
        self.listener, self.env, self.folder = listener, env, folder
        self._stack = stack
        self._simulator = stack.enter_context(ExitStack())
        self.address = self._simulator.enter_context(playground(folder, {"ada": (150, 150)}))
        self.targets: queue.SimpleQueue[tuple[float, int]] = queue.SimpleQueue()
        """The motor targets of the Thymio, each with the time at which it was reported."""

    def play(self, gone: str = "tell") -> Terminal:
        approve(self.address)
        (self.folder / "improv.toml").write_text(TOML.format(address=self.address, gone=gone))
        program = f"beat {60 / BEAT:g}\nada r $ repeat (forward backward)\n"
        play = self._stack.enter_context(Terminal("play", self.folder / "dance.improv", self.env, program))
        bus = Bus.join(self.address)
        bus.listen(bus.find("", 1), lambda words: self.targets.put((time.monotonic(), words[2])))
        return play

    def unplug(self) -> None:
        self._simulator.close()

    def turn(self, before: int) -> tuple[float, int]:
        """Wait until the Thymio drives in another direction than before. Return when, and the direction."""
        while True:
            at, target = self.targets.get(timeout=LIMIT)
            if (sign := (target > 0) - (target < 0)) != before:
                return at, sign


def forward(message: Mapping[str, Any]) -> bool:
    return bool(message["x"] > 0)


def backward(message: Mapping[str, Any]) -> bool:
    return bool(message["x"] < 0)


@pytest.fixture
def mixed(listen: Listen, alone: Mapping[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Mixed]:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    env = {**alone, "XDG_CONFIG_HOME": str(tmp_path / "config")}
    with ExitStack() as stack:
        yield Mixed(listen("/r/cmd_vel"), env, tmp_path, stack)


def test_both_play_on_the_beat_until_one_stop(mixed: Mixed) -> None:
    mixed.play()
    direction = 0
    for _ in range(4):
        at, now = mixed.turn(direction)
        heard = mixed.listener.wait(forward if now > 0 else backward)
        assert heard["at"] == pytest.approx(at, abs=BEAT / 2)
        direction = now
    subprocess.run(stop_within(os.environ["XDG_RUNTIME_DIR"]), env=mixed.env, check=True)
    assert mixed.turn(direction)[1] == 0
    mixed.listener.wait(still)


@pytest.mark.parametrize("gone", ["tell", "stop"])
def test_a_lost_thymio_is_named_and_stops_the_other_one_only_if_people_want_that(mixed: Mixed, gone: str) -> None:
    play = mixed.play(gone)
    mixed.turn(0)
    mixed.listener.wait(moving)
    mixed.unplug()
    assert "ada is gone: the connection to" in play.wait_for_line("gone")
    mixed.listener.hear_all()
    if gone == "tell":
        for _ in range(3):
            mixed.listener.wait(moving)
    else:
        mixed.listener.wait(still)
        assert play.end()[0] == 2
