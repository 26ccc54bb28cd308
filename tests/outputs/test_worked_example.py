"""The worked example in docs/outputs.md moves a robot."""

from __future__ import annotations

import re
import socket
from pathlib import Path

from improv_core.outputs.devices.device import Device, DeviceRobot
from improv_core.score.motion import STILL, Twist

PAGE = (Path(__file__).parents[2] / "docs" / "outputs.md").read_text(encoding="utf-8")


class Silent:
    """Takes readings, of which this robot has none."""

    def sense(self, name: str, value: object) -> None:
        raise AssertionError(name)

    def pose(self, pose: object) -> None:
        raise AssertionError(pose)


def test_the_worked_example_is_short_and_drives_a_robot() -> None:
    found = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert found
    assert found[1].count("\n") <= 60
    names: dict[str, type[Device]] = {}
    exec(found[1], names)
    with socket.create_server(("127.0.0.1", 0)) as server:
        robot = DeviceRobot("ada", f"tcp:127.0.0.1:{server.getsockname()[1]}", None, (0, 0, 0))
        device = names["Text"](robot, Silent())
        device.connect()
        there, _ = server.accept()
        with there:
            device.drive(Twist(0.1, yaw=1.0))
            assert there.recv(100) == b"0.100000 1.000000\n"
            assert not device.stands()
            there.sendall(b"k")
            device.drive(STILL)
            assert device.stands()
        device.close()
