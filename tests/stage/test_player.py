"""What the player sends, and when, by a clock that the tests turn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pytest

from improv_core.analysis import analyze
from improv_core.compiler import score_of
from improv_core.motion import Pose, Twist
from improv_core.score import Part, Score
from improv_core.stage.player import PATIENCE, Player


class Recorder:
    """A sink that remembers what it is sent."""

    name = "recorder"
    period: float | None = None

    def __init__(self) -> None:
        self.sent: list[tuple[str, float, Twist]] = []
        self.deaf: dict[str, str] = {}
        self.prepared: list[bool] = []

    def prepare(self, parts: Mapping[str, Part], restart: bool) -> None:
        self.prepared.append(restart)

    def missing(self) -> dict[str, str]:
        return self.deaf

    def send(self, robot: str, twist: Twist, at: float) -> None:
        self.sent.append((robot, at, twist))

    def advance(self, to: float) -> None: ...

    def poses(self) -> dict[str, Pose]:
        return {}

    def close(self) -> None: ...

    def changes(self, robot: str) -> list[tuple[float, float, float]]:
        """When the robot's velocity changed, and to what forward speed and yaw."""
        changes: list[tuple[float, float, float]] = []
        for name, at, twist in self.sent:
            if name == robot and (not changes or changes[-1][1:] != (twist.x, twist.yaw)):
                changes.append((round(at, 12), twist.x, twist.yaw))
        return changes


class Stage:
    """A player on a recorder, and the clock that drives it: it jumps from deadline to deadline."""

    def __init__(self, start: float = 1000.0) -> None:
        self.now = start
        self.sink = Recorder()
        self.told: list[dict[str, Any]] = []
        self.player = Player(self.sink, self.told.append, lambda: 0.0)

    def load(self, program: str, when: str = "restart") -> None:
        self.player.load(score(program), len(self.told) + 1, when, self.now)

    def run(self, seconds: float) -> None:
        end = self.now + seconds
        while (deadline := self.player.deadline(self.now)) is not None and deadline <= end:
            self.now = max(deadline, self.now)
            self.player.advance(self.now)
        self.now = end

    @property
    def states(self) -> list[str]:
        return [message["state"] for message in self.told if message["type"] == "transport"]


QUARTER = math.pi / 2


def score(program: str) -> Score:
    analysis = analyze(program)
    assert analysis.ok
    return score_of(analysis)


def test_every_change_is_sent_at_its_time_and_zero_at_the_end() -> None:
    stage = Stage()
    stage.load("beat 60\nr $ forward [left left] forward")
    stage.run(10)
    assert stage.sink.changes("r") == [(0, 2, 0), (1, 0, 2 * QUARTER), (2, 2, 0), (3, 0, 0)]
    assert stage.states == ["playing", "ended"]


def test_commands_are_repeated_at_20_hz_and_silent_after_three_zeros() -> None:
    stage = Stage()
    stage.load("r $ forward")
    stage.run(60)
    times = [at for _, at, _ in stage.sink.sent]
    assert times == pytest.approx([step / 20 for step in range(23)])
    assert [twist for _, _, twist in stage.sink.sent[-3:]] == [Twist(), Twist(), Twist()]
    assert stage.player.deadline(stage.now) is None


def test_times_do_not_drift() -> None:
    stage = Stage()
    stage.load("beat 92.5\nr $ repeat (forward [left right left])")
    stage.run(3600)
    changes = [at for at, *_ in stage.sink.changes("r")]
    beat = 60 / 92.5
    assert len(changes) > 10_000
    # Two beats take four changes; the last one is where it has to be to the nanosecond.
    turns, item = divmod(len(changes) - 1, 4)
    assert changes[-1] == pytest.approx(beat * (2 * turns + [0, 1, 4 / 3, 5 / 3][item]), abs=1e-9)


def test_robots_play_together_and_each_stops_at_its_own_end() -> None:
    stage = Stage()
    stage.load("r1 $ forward\nr2 $ left left")
    stage.run(5)
    assert stage.sink.changes("r1") == [(0, 2, 0), (1, 0, 0)]
    assert stage.sink.changes("r2") == [(0, 0, QUARTER), (2, 0, 0)]
    assert [at for _, at, _ in stage.sink.sent] == sorted(at for _, at, _ in stage.sink.sent)


def test_hush_sends_zeros_at_once() -> None:
    stage = Stage()
    stage.load("r $ repeat forward")
    stage.run(1.23)
    stage.player.hush(stage.now)
    assert stage.sink.sent[-1] == ("r", stage.now - 1000, Twist())
    stage.run(10)
    assert [twist for _, _, twist in stage.sink.sent[-3:]] == [Twist(), Twist(), Twist()]
    assert stage.states == ["playing", "stopped"]


def test_a_new_score_restarts_at_beat_0_and_stops_robots_that_left() -> None:
    stage = Stage()
    stage.load("r1 r2 $ repeat forward")
    stage.run(0.5)
    stage.sink.sent.clear()
    stage.load("r1 $ left")
    stage.run(5)
    assert stage.sink.changes("r1") == [(0, 0, QUARTER), (1, 0, 0)]
    assert {twist for name, _, twist in stage.sink.sent if name == "r2"} == {Twist()}
    assert stage.sink.prepared == [True, True]


@pytest.mark.parametrize(("when", "switch"), [("now", 1.25), ("beat", 2.0), ("end", 3.0)])
def test_a_new_score_may_take_over_without_a_gap(when: str, switch: float) -> None:
    stage = Stage()
    stage.load("r gone $ forward forward forward")
    stage.run(1.25)
    stage.load("r $ left", when)
    stage.run(10)
    assert stage.sink.changes("r") == [(0, 2, 0), (switch, 0, QUARTER), (switch + 1, 0, 0)]
    assert stage.sink.changes("gone") == [(0, 2, 0), (switch, 0, 0)]
    assert stage.sink.prepared == [True, False]


def test_the_first_beat_waits_for_listeners_but_not_for_ever() -> None:
    stage = Stage()
    stage.sink.deaf = {"r": "nobody listens on /r/cmd_vel"}
    stage.load("r $ forward")
    stage.run(1)
    assert stage.sink.sent == []
    assert stage.states == ["waiting"]
    stage.sink.deaf = {}
    stage.run(5)
    assert stage.sink.changes("r") == [(0, 2, 0), (1, 0, 0)]

    stage.sink.deaf = {"r2": "nobody listens on /r2/cmd_vel"}
    stage.load("r2 $ forward")
    stage.run(PATIENCE + 0.1)
    assert {"type": "warning", "message": "nobody listens on /r2/cmd_vel"} in stage.told
    assert stage.player.state == "playing"
    stage.load("r2 $ forward")
    assert stage.player.state == "playing"  # it has waited for this robot before


def test_a_swarm_of_tiny_items_can_not_swamp_a_robot() -> None:
    stage = Stage()
    stage.load("r $ fast 1000000 repeat 1000000 (forward left)")
    stage.run(5)
    assert len(stage.sink.sent) <= 2004
    assert stage.sink.changes("r")[-1] == (2, 0, 0)


def test_endless_constant_programs_are_played_lazily() -> None:
    stage = Stage()
    stage.load("r $ repeat 1000000000 (repeat 1000000000 forward)")
    stage.run(2)
    assert len(stage.sink.sent) == 41
