"""Commands to joints that are sent together."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from improv_core.player.limb_tracks import JointCommands
from improv_core.score.joints import JointMotion

Sent = list[tuple[str, list[str], float]]


class Sender:
    """A sender of commands. Robots whose names begin with x can't be reached."""

    def __init__(self) -> None:
        self.sent: Sent = []

    def send(self, robot: str, joints: Mapping[str, JointMotion], at: float) -> None:
        if robot.startswith("x"):
            raise OSError(robot)
        self.sent.append((robot, [*joints], at))


def tell(commands: JointCommands, robot: str, joint: str, at: float = 0.0) -> None:
    commands.tell(robot, {joint: JointMotion(0.0, 1.0)}, at)


def test_alone_each_command_is_sent_at_once() -> None:
    sender = Sender()
    commands = JointCommands(sender.send)
    tell(commands, "a", "yaw")
    assert sender.sent == [("a", ["yaw"], 0)]
    tell(commands, "a", "pitch")
    assert sender.sent == [("a", ["yaw"], 0), ("a", ["pitch"], 0)]


def test_together_commands_to_one_robot_for_the_same_time_are_sent_at_once() -> None:
    sender = Sender()
    commands = JointCommands(sender.send)
    with commands.together():
        for at in (0, 1):
            for robot in "ab":
                for joint in ("yaw", "pitch"):
                    tell(commands, robot, joint, at)
    assert sender.sent == [(robot, ["yaw", "pitch"], at) for at in (0, 1) for robot in "ab"]
    tell(commands, "b", "yaw", 1)
    assert sender.sent[4:] == [("b", ["yaw"], 1)]


def test_a_robot_that_can_not_be_reached_keeps_nothing_from_others() -> None:
    sender = Sender()
    commands = JointCommands(sender.send)

    def tell_both() -> None:
        with commands.together():
            tell(commands, "x", "yaw")
            tell(commands, "a", "yaw")

    with pytest.raises(OSError, match="x"):
        tell_both()
    assert sender.sent == [("a", ["yaw"], 0)]
    tell(commands, "a", "pitch")
    assert sender.sent[1:] == [("a", ["pitch"], 0)]
