"""Robots here and on another machine dance as one: a real ssh server, and a real stage behind it."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Awaitable, Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from improv_core.ipc.stage_process import Stage
from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.safety.stage_stops import stop_stages
from improv_core.safety.stops import Stops
from improv_core.session import start as starting
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import HERE, PlayScore, StageKey
from tests.hosts.sshd import NAME, Host, a_host
from tests.ros.conftest import LIMIT, Listen, be_patient, with_limits
from tests.ros.dance import moving, still
from tests.ros.test_link import process_of, set_there

pytestmark = pytest.mark.slow("starts a stage here and one through ssh")

ROBOTS = read_robots(
    f'[robots.p]\nhost = "{NAME}"\nlink_patience = 10\n\n[robots.q]\nhost = "{NAME}"\nlink_patience = 3\n'
)
STEADY = 64
"""Twists of a robot, 20 a second: for longer than the other machine's patience."""


@pytest.fixture
def host(alone: Mapping[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Host]:
    """Another machine in the same network as the robots of this test."""
    there = set_there(alone)
    with a_host(tmp_path, there) as made:
        ssh = tmp_path / "here" / "bin" / "ssh"
        ssh.parent.mkdir(parents=True)
        ssh.write_text(f'#!/bin/sh\nexec /usr/bin/ssh -F {made.config} "$@"\n')
        ssh.chmod(0o755)
        for name, value in {**alone, **made.env, **there, "PATH": f"{ssh.parent}:{os.environ['PATH']}"}.items():
            monkeypatch.setenv(name, value)
        be_patient(monkeypatch)
        monkeypatch.setattr(starting, "LATEST", LIMIT)
        yield made


class Show:
    """A playback and its messages."""

    def __init__(self) -> None:
        self.told: list[Any] = []
        self.changed = asyncio.Event()
        self.stops = Stops()
        self.playback = Playback(Options("ros", find_python=find_ros_python), self._hear, self.stops)

    def _hear(self, message: Any, leads: bool) -> None:
        self.told.append(message)
        self.changed.set()

    async def play(self, text: str) -> None:
        await self.playback.play(PlayScore(score_of(analyze(text, ROBOTS)), "dance.improv", self.stops.count))

    async def until(self, fits: Callable[[Any], bool]) -> Any:
        """Wait for a message that fits, and return it."""

        async def look() -> Any:
            while not (found := [message for message in self.told if fits(message)]):
                self.changed.clear()
                await self.changed.wait()
            return found[0]

        return await asyncio.wait_for(look(), LIMIT)


def perform(test: Callable[[Show], Awaitable[None]]) -> None:
    async def run() -> None:
        show = Show()
        try:
            await test(show)
        finally:
            await show.playback.close()

    asyncio.run(run())


def test_robots_here_and_there_dance_until_a_stop_and_a_host_that_comes_back_joins(host: Host, listen: Listen) -> None:
    here, there = listen("/a/cmd_vel"), listen("/p/cmd_vel")

    async def test(show: Show) -> None:
        await show.play("a p $ repeat forward\n")
        began = [(await asyncio.to_thread(robot.wait, moving))["at"] for robot in (here, there)]
        assert abs(began[1] - began[0]) < 5, "at one instant, on a busy machine"
        assert "on robot" in show.playback.state.status
        await show.until(lambda message: message["type"] == "link")

        os.kill(process_of(str(host.cache), "--sink"), signal.SIGKILL)
        await asyncio.to_thread(there.wait, still)
        await asyncio.to_thread(there.wait, moving)
        assert any(f"{NAME}: " in message.get("message", "") for message in show.told)

        assert show.playback._show
        # It goes straight to both stages, while this event loop does nothing. The new one there may be yet to listen.
        while waits_for := stop_stages(show.playback._show, {"type": "stop", "direct": "p 1"}, LIMIT):
            assert waits_for == [NAME]
        assert waits_for == []
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, still)
        await show.until(lambda message: message["type"] == "transport" and message["state"] == "stopped")
        assert show.stops.count == 1

    perform(test)


def test_a_person_has_all_resume_after_all_stages_have_died(host: Host, listen: Listen) -> None:
    here, there = listen("/a/cmd_vel"), listen("/p/cmd_vel")

    async def test(show: Show) -> None:
        await show.play("a p $ repeat forward\n")
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, moving)
        stage = show.playback._stages[StageKey(HERE, "ros")]
        assert isinstance(stage, Stage)
        os.kill(process_of(str(host.cache), "--sink"), signal.SIGKILL)
        await show.until(lambda message: message.get("message", "").startswith(f"{NAME}: "))
        os.kill(stage.pid, signal.SIGKILL)  # before another one there could play
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, still)
            robot.heard.clear()
        offer = await show.until(lambda message: "resumes" in message)
        for robot in (here, there):
            robot.hear_all()
            assert all(map(still, robot.heard)), "none moves by itself"
        show.playback.ask({"type": "resume", "beat": offer["resumes"]["beat"]}, show.stops.count)
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, moving)
        assert show.playback.state.mode == "playing"

    perform(test)


def test_after_a_short_gap_in_the_link_robots_here_and_there_dance_on_together(
    host: Host, listen: Listen, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in with_limits(hosts__near__BEYOND=LIMIT).items():
        monkeypatch.setenv(name, value)
    host.relay()
    here, there = listen("/a/cmd_vel"), listen("/q/cmd_vel")

    async def test(show: Show) -> None:
        await show.play("a q $ repeat forward\n")
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, moving)
        await show.until(lambda message: message["type"] == "link")
        here.hear_all()
        here.heard.clear()
        way = process_of("relay.py")
        os.kill(way, signal.SIGSTOP)
        await asyncio.to_thread(there.wait, still)
        os.kill(way, signal.SIGCONT)
        await asyncio.to_thread(there.wait, moving)
        await show.until(lambda message: "they join the others again" in message.get("message", ""))
        there.heard.clear()
        for robot in (here, there):
            robot.hear_all()
            for _ in range(STEADY):
                await asyncio.to_thread(robot.wait, moving)
            assert not any(map(still, robot.heard)), "one never stops, the other not again"
        assert show.playback.stop({"type": "stop"}).endswith(": 2 robots were moving")
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, still)

    perform(test)


def test_at_the_end_robots_behind_a_silent_link_are_named(host: Host, listen: Listen) -> None:
    host.relay()
    here, there = listen("/a/cmd_vel"), listen("/p/cmd_vel")

    async def test(show: Show) -> None:
        await show.play("a p $ repeat forward\n")
        for robot in (here, there):
            await asyncio.to_thread(robot.wait, moving)
        way = process_of("relay.py")
        os.kill(way, signal.SIGSTOP)
        try:
            await show.playback.close()
            named = await show.until(lambda message: message["type"] == "unreached")
            assert named["message"] == f"p may still be moving: {NAME} has not confirmed the stop"
            await asyncio.to_thread(here.wait, still)
        finally:
            os.kill(way, signal.SIGCONT)
        await asyncio.to_thread(there.wait, still)

    perform(test)
