"""The zeros that robots may not have received, on a clock that the tests advance."""

from __future__ import annotations

import math
from typing import Any

from improv_core.outputs.ros.standby.client import Standby
from improv_core.outputs.ros.subscriber_check import ZEROS
from improv_core.outputs.ros.zero_sender import PendingZeros
from improv_core.safety.pending_zeros import LIMIT, PERIOD

LOOK = 0.05


class Topic:
    """A topic with one listener, which confirms or not."""

    name, was_heard = "/r/cmd_vel", True

    def __init__(self) -> None:
        self.sent = 0
        self.answers = False

    def count_listeners(self) -> int:
        return 1

    def has_confirmed(self) -> bool:
        return self.answers

    def confirms(self) -> bool:
        return True

    def publish(self, message: bytes, clock: object, frame: bytes) -> None:
        self.sent += 1


class Sender:
    """The zeros of one robot, and the lines about it."""

    def __init__(self) -> None:
        self.now = 0.0
        self.lines: list[str] = []
        self.topic: Any = Topic()
        self.standby = Standby("node", (), lambda: self.now, False, self.lines.append)
        self.zeros = PendingZeros(self.standby, None, lambda topic: (), self.lines.append, lambda: self.now)

    def retry(self, seconds: float) -> None:
        end = self.now + seconds
        while self.now < end:
            self.now += LOOK
            self.zeros.retry(self.now)


def test_a_zero_is_sent_again_until_it_is_confirmed() -> None:
    sender = Sender()
    sender.zeros.note_velocity(sender.topic, "base")
    assert sender.standby.moving == {"/r/cmd_vel": "base"}
    sender.zeros.note_zero("r", sender.topic, "base")
    assert sender.standby.moving == {}
    sender.retry(PERIOD)
    assert sender.topic.sent == ZEROS, "then DDS asks for a confirmation"
    sender.retry(PERIOD)
    assert sender.topic.sent == ZEROS + 1
    sender.topic.answers = True
    sender.retry(3.0)
    assert (sender.zeros.due, sender.lines) == (math.inf, [])


def test_a_robot_that_did_not_move_has_no_pending_zero() -> None:
    sender = Sender()
    sender.zeros.note_zero("r", sender.topic, "base")
    assert sender.zeros.due == math.inf


def test_a_robot_that_moves_again_needs_no_zero() -> None:
    sender = Sender()
    for note in (sender.zeros.note_velocity, sender.zeros.note_velocity):
        note(sender.topic, "base")
        sender.zeros.note_zero("r", sender.topic, "base")
    sender.zeros.note_velocity(sender.topic, "base")
    assert sender.zeros.due == math.inf


def test_a_line_names_a_robot_that_never_confirms() -> None:
    sender = Sender()
    sender.zeros.note_inherited("r", sender.topic, "base")
    sender.retry(LIMIT + 1)
    (line,) = sender.lines
    assert line.startswith("r may still be moving: no listener on /r/cmd_vel has confirmed the stop")
