"""A player that waits, with everything ready, for a person or for the wall clock."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import pytest

from improv_core.player.player import Player
from improv_core.protocol.messages import Arming, CountJson
from improv_core.score.score import Score
from tests.player.test_player import Stage, score

AHEAD = 1e9
"""Seconds from the monotonic clock to Unix time."""
DANCE = score("beat 60\nr $ forward left\n")


@dataclass
class Armed:
    stage: Stage = field(default_factory=Stage)
    ahead: float = AHEAD

    def __post_init__(self) -> None:
        self.stage.player = Player(self.stage.sink, self.stage.told.append, lambda: self.stage.now + self.ahead)

    def load(self, arming: Arming | None, dance: Score = DANCE) -> None:
        self.stage.perform(dance, arming=arming)

    @property
    def zero(self) -> float | None:
        """The time of beat 0, in seconds since the stage was started; None if it has not begun."""
        run = self.stage.player.run
        return run.transport.zero - 1000.0 if run.mode in ("playing", "ended") else None

    @property
    def says(self) -> list[bool]:
        return [message["armed"] for message in self.stage.told if message["type"] == "armed"]

    @property
    def counts(self) -> list[tuple[float, CountJson | None]]:
        """The reported times of beat 0, in seconds since the stage was started, and the beats counted before it."""
        told = [message for message in self.stage.told if message["type"] == "armed" and message["begins"]]
        return [(round((each["begins"] or 0) - 1000.0 - self.ahead, 3), each.get("count")) for each in told]


COUNTED = replace(DANCE, count_in=True)
FOUR: CountJson = {"beats": 4, "period": 1.0}


@pytest.mark.parametrize(
    ("dance", "zero", "count"),
    [
        (COUNTED, 4.0, FOUR),
        (replace(COUNTED, bar=3), 3.0, {"beats": 3, "period": 1.0}),
        (replace(score("beat 120\nr $ forward\n"), count_in=True), 2.0, {"beats": 4, "period": 0.5}),
    ],
)
def test_a_bar_is_counted_before_beat_0_which_is_known_from_its_beginning(
    dance: Score, zero: float, count: CountJson
) -> None:
    armed = Armed()
    armed.load(None, dance)
    armed.stage.run(0)
    assert armed.counts == [(zero, count)]
    armed.stage.run(6)
    assert armed.zero == pytest.approx(zero, abs=1e-6)
    assert armed.says == [True, False]
    assert armed.stage.lines == []


def test_a_person_begins_a_count_and_can_not_shorten_it() -> None:
    armed = Armed()
    armed.load({}, COUNTED)
    armed.stage.run(10)
    assert armed.counts == []
    armed.stage.ask("resume")
    armed.stage.run(2)
    armed.stage.ask("resume")
    armed.stage.run(10)
    assert armed.counts == [(14.0, FOUR)]
    assert armed.zero == pytest.approx(14, abs=1e-6)


def test_the_last_bar_before_a_time_is_counted() -> None:
    armed = Armed()
    armed.load({"begins": 1000.0 + AHEAD + 20}, COUNTED)
    armed.stage.run(30)
    assert armed.counts == [(20.0, FOUR)]
    assert armed.zero == pytest.approx(20, abs=1e-3)


@pytest.mark.parametrize(
    ("at", "set_by", "begins"),
    [
        (7.25, 0.0, 7.25),
        (7.25, 2.0, 5.25),  # the clock was set while it waited
        (7.25, -2.0, 9.25),
        (0.0, 0.0, 0.0),
    ],
)
def test_it_begins_at_its_time_on_the_wall_clock(at: float, set_by: float, begins: float) -> None:
    armed = Armed()
    armed.load({"begins": 1000.0 + AHEAD + at})
    armed.stage.run(3)
    armed.ahead += set_by
    armed.stage.run(10)
    assert armed.zero == pytest.approx(begins, abs=1e-3)
    assert armed.stage.sink.changes("r")[0] == (0, 2, 0)
    assert armed.says == ([True, False] if at else [])


@pytest.mark.parametrize("set_by", [3600.0, 2.0, -2.0, -3600.0])
def test_a_count_lasts_as_long_if_the_wall_clock_is_set_meanwhile(set_by: float) -> None:
    armed = Armed()
    armed.load(None, COUNTED)
    armed.stage.run(1)
    armed.ahead += set_by
    armed.stage.run(6)
    assert armed.zero == pytest.approx(4, abs=1e-6)
    assert armed.stage.lines == []


@pytest.mark.parametrize("arming", [None, {"begins": 1000.0 + AHEAD + 4}], ids=["counted", "at a time"])
@pytest.mark.parametrize(
    ("since", "hung", "state"),
    [
        (3.9, 0.4, "playing"),  # a little late
        (1.0, 2.9, "playing"),  # it runs again in time
        (1.0, 9.0, "stopped"),  # as if somebody had just asked for it
        (3.95, 0.7, "stopped"),
    ],
)
def test_real_robots_stay_where_they_are_if_the_stage_hung_at_beat_0(
    arming: Arming | None, since: float, hung: float, state: str
) -> None:
    armed = Armed()
    armed.stage.sink.real = True
    armed.load(arming, COUNTED)
    armed.stage.run(since)
    armed.stage.hang(hung)
    armed.stage.run(10)
    lines = [line for line in armed.stage.lines if "stalled" in line]
    assert armed.stage.player.run.mode == ("ended" if state == "playing" else state)
    assert bool(lines) == (state == "stopped")
    assert any(twist.x for _, _, twist in armed.stage.sink.sent) == (state == "playing")


def test_setting_the_wall_clock_does_not_count_as_a_hang() -> None:
    armed = Armed()
    armed.stage.sink.real = True
    armed.load(Arming(begins=1000.0 + AHEAD + 20), COUNTED)
    armed.stage.run(1)
    armed.ahead += 60
    armed.stage.run(1)
    assert armed.stage.player.run.mode == "playing"


def test_simulated_robots_begin_late_after_the_stage_hung() -> None:
    armed = Armed()
    armed.load(None, COUNTED)
    armed.stage.run(1)
    armed.stage.hang(9)
    armed.stage.run(1)
    assert armed.stage.player.run.mode == "playing"
