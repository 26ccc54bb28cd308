"""A stop while the radio link to a robot is down: two hosts, real DDS, and a cable that is pulled."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from improv_core.safety.zeros import LAST_ZEROS
from tests.commands.command_line import IMPROV, stop_within
from tests.ros.conftest import LIMIT, SHORT_LEASE, Listener, Others
from tests.ros.dance import still
from tests.ros.hosts import on_one_link, set_link

pytestmark = pytest.mark.slow("hosts of a network lose each other, and find each other again")

KINDS = {"reliable": False, "best effort": True}


class Field:
    """Improv on one host, and on the other a robot of each kind, which all listen on one topic."""

    def __init__(self, stack: ExitStack, python: str, env: Mapping[str, str], folder: Path) -> None:
        there, self._here = stack.enter_context(on_one_link())
        self._there = there
        self._runtime = stack.enter_context(TemporaryDirectory(dir="/tmp"))  # paths of sockets must be short
        self._env = {**env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "XDG_RUNTIME_DIR": self._runtime}
        self._env["FASTDDS_BUILTIN_TRANSPORTS"] = "UDPv4"  # processes of one host here share no memory
        (folder / "dance.improv").write_text("r $ repeat forward\n")
        over_there = Others(there.wrapper(python, folder), self._env)
        stack.callback(over_there.close)
        self.robots = {
            kind: Listener(over_there, "/r/cmd_vel", name=kind.replace(" ", "_"), best_effort=best_effort)
            for kind, best_effort in KINDS.items()
        }
        beside = Others(self._here.wrapper(python, folder), self._env)
        stack.callback(beside.close)
        self._witness = Listener(beside, "/r/cmd_vel", name="witness")
        file = str(folder / "dance.improv")
        self.playing = self.run(*IMPROV, "watch", "--backend", "ros", "--no-browser", file)
        stack.callback(self.end)
        for robot in (*self.robots.values(), self._witness):
            robot.wait(lambda message: message["x"] > 0)

    def run(self, *command: str) -> subprocess.Popen[str]:
        """Run a command on this side of the link."""
        command = tuple(self._here.command(*command))
        return subprocess.Popen(command, env=self._env, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def link(self, up: bool) -> float:
        """Pull the cable, or plug it in again; when that was."""
        set_link(self._there, up)
        return time.monotonic()

    def stop(self) -> None:
        """Somebody stops everything. A listener on this side of the link has heard all zeros of that."""
        assert self.run(*stop_within(self._runtime)).wait(LIMIT) == 0
        for _ in range(LAST_ZEROS):
            self._witness.wait(still)

    def wait_until_found(self) -> None:
        """Wait until each robot has found the stage and its standby."""
        for robot in self.robots.values():
            robot.wait_for_publishers(lambda count: count == 2)

    def robots_stand_from(self, back: float) -> None:
        """Each robot is told to stop once the link is back, and never to move again."""
        for robot in self.robots.values():
            zero = robot.wait(lambda message: message["at"] > back and still(message))["at"]
            robot.hear_all()
            assert all(still(message) for message in robot.heard if message["at"] >= zero)

    def end(self) -> None:
        """Whoever plays this ends it, and the stage with it."""
        self.playing.terminate()
        self.playing.wait(LIMIT)


@pytest.fixture
def field(ros_python: str, ros_env: Mapping[str, str], tmp_path: Path) -> Iterator[Field]:
    """Robots are dropped two seconds after the link is gone, which usually takes 20."""
    with ExitStack() as stack:
        yield Field(stack, ros_python, {**ros_env, **SHORT_LEASE}, tmp_path)


@pytest.fixture
def patient(ros_python: str, ros_env: Mapping[str, str], tmp_path: Path) -> Iterator[Field]:
    """Robots are dropped 20 seconds after the link is gone, as usual: a gap on a busy machine is shorter than that."""
    with ExitStack() as stack:
        yield Field(stack, ros_python, ros_env, tmp_path)


def test_a_stop_in_a_short_gap(patient: Field) -> None:
    patient.link(up=False)
    patient.stop()
    back = patient.link(up=True)
    patient.robots_stand_from(back)


def test_an_end_in_a_gap_long_enough_for_robots_to_be_forgotten(field: Field) -> None:
    """Ctrl-C: the standby stays until they have heard it."""
    field.wait_until_found()
    field.link(up=False)
    field.end()
    for robot in field.robots.values():
        robot.wait_for_publishers(lambda count: not count)
    back = field.link(up=True)
    field.robots_stand_from(back)
