"""A player that waits, with everything ready, for a person or for the wall clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from improv_core.score.motion import Twist
from improv_core.stage.gate import Gate
from improv_core.stage.listeners import PATIENCE
from improv_core.stage.machine import LOOK_WHILE_ARMED
from improv_core.stage.player import Player
from tests.stage.test_player import Stage, score

AHEAD = 1e9
"""Seconds from the monotonic clock to Unix time."""
DANCE = score("beat 60\nr $ forward left\n")


@dataclass
class Armed:
    """A stage with a wall clock."""

    stage: Stage = field(default_factory=Stage)
    ahead: float = AHEAD

    def __post_init__(self) -> None:
        self.stage.player = Player(self.stage.sink, self.stage.told.append, lambda: self.stage.now + self.ahead)

    def load(self, gate: Gate | None) -> None:
        self.stage.player.load(DANCE, 1, "restart", self.stage.now, gate=gate)

    @property
    def zero(self) -> float | None:
        """When it began, in seconds since the stage was started; None if it has not."""
        run = self.stage.player.run
        return run.transport.zero - 1000.0 if run.mode in ("playing", "ended") else None

    @property
    def says(self) -> list[bool]:
        return [message["armed"] for message in self.stage.told if message["type"] == "armed"]


@pytest.mark.parametrize(
    ("at", "set_by", "begins"),
    [
        (7.25, 0.0, 7.25),
        (7.25, 2.0, 5.25),  # the clock was set while it waited
        (7.25, -2.0, 9.25),
        (0.0, 0.0, 0.0),
    ],
)
def test_it_begins_when_the_wall_clock_says(at: float, set_by: float, begins: float) -> None:
    armed = Armed()
    armed.load(Gate(1000.0 + AHEAD + at))
    armed.stage.run(3)
    armed.ahead += set_by
    armed.stage.run(10)
    assert armed.zero == pytest.approx(begins, abs=1e-3)
    assert armed.stage.sink.changes("r")[0] == (0, 2, 0)
    assert armed.says == ([True, False] if at else [])


def test_if_the_clock_is_set_past_its_time_it_begins_within_one_look() -> None:
    armed = Armed()
    armed.load(Gate(1000.0 + AHEAD + 60))
    armed.stage.run(3)
    armed.ahead += 100
    armed.stage.run(10)
    assert armed.zero == pytest.approx(3, abs=LOOK_WHILE_ARMED)
    assert "late" in armed.stage.lines[0]


def test_a_person_begins_it_and_it_looks_for_nobody_again() -> None:
    armed = Armed()
    armed.stage.sink.deaf = {"r": "nothing is listening on /r/cmd_vel"}
    armed.load(Gate())
    armed.stage.run(1)
    armed.stage.player.resume(armed.stage.now)
    assert armed.zero is None, "it was not ready"
    armed.stage.run(PATIENCE + 30)
    assert (armed.zero, armed.says, armed.stage.states) == (None, [True], ["waiting", "waiting"])
    armed.stage.player.resume(armed.stage.now)
    armed.stage.run(0)
    assert armed.zero == PATIENCE + 31
    assert armed.stage.sink.sent[-1][2].x > 0, "at once"


@pytest.mark.parametrize("stop", [Player.stop, Player.pause])
def test_after_a_stop_neither_the_clock_nor_a_person_begins_it(stop: Callable[[Player, float], None]) -> None:
    armed = Armed()
    armed.load(Gate(1000.0 + AHEAD + 5))
    armed.stage.run(3)
    stop(armed.stage.player, armed.stage.now)
    armed.stage.run(10)
    armed.stage.player.resume(armed.stage.now)
    armed.stage.run(10)
    assert (armed.stage.player.state, armed.says) == ("stopped", [True, False])
    assert {twist for _, _, twist in armed.stage.sink.sent} == {Twist()}, "zeros, and nothing else"


def test_restart_begins_without_waiting() -> None:
    armed = Armed()
    armed.load(Gate())
    armed.stage.run(3)
    armed.load(None)
    armed.stage.run(1)
    assert (armed.zero, armed.says) == (3, [True, False])
