"""Effects of OSC messages on real robots: a base that listens in ROS 2, and a socket that sends."""

from __future__ import annotations

import socket
import time
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

import pytest

from improv_core.music.osc_wire import Argument, plain
from improv_core.protocol.play_again import STOPPED
from tests.ros.conftest import LIMIT, Listen
from tests.ros.dance import Server, at_speed, still

pytestmark = pytest.mark.slow("starts what plays, and a base that listens in ROS 2")

PROGRAM = "beat 60\nturtle1 $ repeat (if kick backward else forward)\n"
SPEED = 2.0
"""m/s of a step of 2 m at tempo 60."""


class Desk:
    """A music program that sends to Improv, and listens to its messages."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(LIMIT)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            self._improv = free.getsockname()

    @property
    def section(self) -> str:
        return (
            f'[osc]\nlisten = {self._improv[1]}\nsend = ["127.0.0.1:{self._socket.getsockname()[1]}"]\n'
            'time_tags = false\n[senses.kick]\nosc = "kick"\n'
        )

    def send(self, address: str, *arguments: Argument) -> None:
        self._socket.sendto(plain(f"/improv/{address}", arguments), self._improv)

    def hear(self, beginning: bytes) -> None:
        """Wait for a message that begins like this."""
        end = time.monotonic() + LIMIT
        while not self._socket.recv(4096).startswith(beginning):
            assert time.monotonic() < end

    def close(self) -> None:
        self._socket.close()


def test_osc_plays_stops_and_changes_senses_but_moves_no_real_robot_that_a_person_has_stopped(
    listen: Listen, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    robot = listen("/turtle1/cmd_vel")
    uri = (tmp_path / "dance.improv").as_uri()
    with closing(Desk()) as desk, Server(ros_env, uri=uri) as editor:
        (tmp_path / "improv.toml").write_text(desk.section)
        editor.save(PROGRAM)
        robot.wait(at_speed(SPEED))
        desk.hear(plain("/improv/state", ["playing"]))
        desk.hear(b"/improv/beat\0")
        for value, speed in ((1, -SPEED), (0, SPEED)):
            desk.send("sense", "kick", "turtle1", value)
            robot.wait(at_speed(speed))
        desk.send("tempo", 30)
        robot.wait(at_speed(SPEED / 2))
        for address, state in (("pause", "paused"), ("stop", "stopped")):
            desk.send(address)
            robot.wait(still)
            desk.hear(plain("/improv/state", [state]))
            desk.send("play")
            robot.wait(at_speed(SPEED / 2))

        editor.client.request("workspace/executeCommand", {"command": "improv.stop"})
        robot.wait(still)
        desk.hear(plain("/improv/state", ["stopped"]))
        robot.hear_all()
        before = len(robot.heard)
        desk.send("tempo", 60)
        desk.send("seek", 0)
        desk.hear(plain("/improv/state", ["paused"]))
        desk.send("play")
        editor.wait_for_line(f"an OSC message was ignored: /improv/play: {STOPPED}")
        editor.client.request("workspace/executeCommand", {"command": "improv.resume"})
        begun = robot.wait(at_speed(SPEED))
        assert all(map(still, robot.heard[before : robot.heard.index(begun)]))
        editor.complaints()
