"""The stage's side of the standby, on a clock that the tests advance: its messages to the process, and its
replacement."""

from __future__ import annotations

import json
from typing import Any

import pytest

from improv_core.outputs.ros.standby import client
from improv_core.outputs.ros.standby.client import ANSWER_LIMIT, PULSE_PERIOD, READY_LIMIT, Standby
from improv_core.protocol.limits import HANG_LIMIT

TOPIC = "/r/cmd_vel"
FOUND = {"type": "found", "topic": TOPIC, "kind": "Twist"}


class Process:
    def __init__(self) -> None:
        self.told: list[Any] = []
        self.says: list[Any] = []
        self.ended = self.killed = False

    def read(self, seconds: float) -> list[bytes]:
        if self.ended:
            raise EOFError
        said, self.says = self.says, []
        return [json.dumps(each).encode() for each in said]

    def write(self, line: bytes) -> None:
        self.told.append(json.loads(line))

    def kill(self) -> None:
        self.killed = True

    def end(self) -> None:
        """Do nothing: nothing waits for it."""


class Stage:
    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        self.started: list[Process] = []
        self.can_start = True
        self.alarms: list[str] = []
        patch.setattr(client, "AGAIN", 0.0)
        patch.setattr(client, "Child", self._start)
        self.standby = Standby("node", (), lambda: self.now, True, self.alarms.append)
        self.standby.publish(TOPIC, "Twist", False, lambda: 1)
        self.started[0].says = [FOUND]
        self.standby.look()
        self.standby.note_velocity(TOPIC, "base_link")

    def live(self, seconds: float) -> None:
        """Let time pass. The latest process answers nothing."""
        end = self.now + seconds
        while self.now < end:
            self.now += PULSE_PERIOD
            self.standby.live()
            if self.standby._starting:
                self.standby._starting.join()

    def _start(self, command: object, policy: object) -> Process:
        if not self.can_start:
            raise OSError("no more processes")
        self.started.append(Process())
        return self.started[-1]


@pytest.fixture
def stage(monkeypatch: pytest.MonkeyPatch) -> Stage:
    return Stage(monkeypatch)


@pytest.mark.parametrize(("ends", "what"), [(True, "has ended"), (False, "does not answer")])
def test_a_lost_standby_is_replaced_by_one_that_knows_the_same(stage: Stage, ends: bool, what: str) -> None:
    lost = stage.started[0]
    lost.ended = ends
    stage.live(ANSWER_LIMIT + 1)
    new = stage.started[1]
    assert stage.standby.problem == f"the standby process {what}: another one starts"
    assert lost.killed, "it could wake up again"
    assert new.told[:2] == [
        {"type": "publish", "topic": TOPIC, "kind": "Twist", "second": False, "joints": 0},
        {"type": "moves", "topic": TOPIC, "frame": "base_link", "patience": HANG_LIMIT + PULSE_PERIOD},
    ]
    new.says = [{"type": "alive"}]
    stage.standby.renew()
    assert not stage.standby.is_ready({TOPIC}), "it has yet to find the listener"
    new.says = [FOUND]
    stage.standby.renew()
    assert stage.standby.is_ready({TOPIC})
    stage.standby.renew()
    assert stage.standby.problem is None


def test_beat_0_waits_a_few_seconds_until_the_standby_has_found_the_robots(stage: Stage) -> None:
    other = "/s/cmd_vel"
    stage.standby.publish(other, "Twist", False, lambda: 1)
    assert not stage.standby.under_way({other}), "it plays already"
    stage.standby.await_listeners()
    assert [stage.standby.under_way({topic}) for topic in (TOPIC, other)] == [False, True]
    stage.now += client.FIND_LIMIT
    assert not stage.standby.under_way({other})


def test_robots_that_move_without_a_standby_for_too_long_are_stopped(stage: Stage) -> None:
    """tests/stage/test_loop.py tests the stage's reaction to the alarm."""
    stage.can_start, stage.started[0].ended = False, True
    stage.live(READY_LIMIT - 0.5)
    assert stage.alarms == []
    stage.live(1.0)
    assert stage.alarms[0] == (
        f"no standby process was ready to stop the robots for {READY_LIMIT:g} s, so all were stopped: "
        "play again, or turn off `ros.standby`"
    )
    assert stage.standby.problem == "the standby process can't start (no more processes): another one starts"
