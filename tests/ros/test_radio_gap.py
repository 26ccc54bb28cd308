"""A stop while the radio link to a robot is down: two hosts, real DDS, and an unplugged cable."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from improv_core.outputs.ros.nodes import TRANSPORTS
from improv_core.safety.pending_zeros import LAST_ZEROS
from tests.commands.command_line import IMPROV, stop_within
from tests.ros.conftest import LIMIT, SHORT_LEASE, Listener, Others
from tests.ros.dance import still
from tests.ros.hosts import on_one_link, set_link

pytestmark = pytest.mark.slow("hosts of a network lose each other, and find each other again")

KINDS = {"reliable": False, "best effort": True}


class Field:
    """Improv on one host, and a robot of each kind on the other, all of which listen on one topic."""

    def __init__(self, stack: ExitStack, python: str, env: Mapping[str, str], folder: Path) -> None:
        there, self._here = stack.enter_context(on_one_link())
        self._there = there
        self._runtime = stack.enter_context(TemporaryDirectory(dir="/tmp"))  # paths of sockets must be short
        self._env = {**env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "XDG_RUNTIME_DIR": self._runtime}
        self._env[TRANSPORTS] = "UDPv4"  # processes of one host here share no memory
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
        """Unplug the cable, or plug it in again. Return the time."""
        set_link(self._there, up)
        return time.monotonic()

    def stop(self) -> None:
        """Stop everything, and wait until a listener on this side of the link has heard all zeros."""
        assert self.run(*stop_within(self._runtime)).wait(LIMIT) == 0
        for _ in range(LAST_ZEROS):
            self._witness.wait(still)

    def wait_until_found(self) -> None:
        """Wait until each robot has found the stage and its standby."""
        for robot in self.robots.values():
            robot.wait_for_publishers(lambda count: count == 2)

    def robots_stand_from(self, back: float) -> None:
        """Check that each robot hears a stop once the link is back, and no movement after it."""
        for robot in self.robots.values():
            zero = robot.wait(lambda message: message["at"] > back and still(message))["at"]
            robot.hear_all()
            assert all(still(message) for message in robot.heard if message["at"] >= zero)

    def end(self) -> None:
        """End the player, and the stage with it."""
        self.playing.terminate()
        self.playing.wait(LIMIT)


@pytest.fixture
def field(ros_python: str, ros_env: Mapping[str, str], tmp_path: Path) -> Iterator[Field]:
    """A field in which DDS drops robots two seconds after the link is gone, which usually takes 20."""
    with ExitStack() as stack:
        yield Field(stack, ros_python, {**ros_env, **SHORT_LEASE}, tmp_path)


@pytest.fixture
def patient(ros_python: str, ros_env: Mapping[str, str], tmp_path: Path) -> Iterator[Field]:
    """A field in which DDS drops robots 20 s after the link is gone, as usual: a gap on a busy machine is shorter."""
    with ExitStack() as stack:
        yield Field(stack, ros_python, ros_env, tmp_path)


def test_a_stop_in_a_short_gap_arrives_after_it(patient: Field) -> None:
    patient.link(up=False)
    patient.stop()
    back = patient.link(up=True)
    patient.robots_stand_from(back)


def test_a_stop_at_the_end_reaches_robots_that_were_forgotten_in_a_gap(field: Field) -> None:
    """After Ctrl-C, the standby stays until they have heard the stop."""
    field.wait_until_found()
    field.link(up=False)
    field.end()
    for robot in field.robots.values():
        robot.wait_for_publishers(lambda count: not count)
    back = field.link(up=True)
    field.robots_stand_from(back)
