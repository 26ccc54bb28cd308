"""The examples in which robots react, in the real simulator, faster than real time."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

import pytest

from improv_core.commands.programs import read_to_play
from improv_core.commands.rehearsal import perform
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.reports import Told
from improv_core.player.sensing import Foreseen
from improv_core.program.compiler import score_of
from improv_core.score.motion import Twist
from improv_core.score.senses import CUE, RobotSense
from tests.commands.command_line import REACTING

BEAT = 60 / 100
"""Seconds of a beat in `cue.improv`."""
DANCERS = ["ada", "bo", "cy"]


class Watched(Simulator):
    """A simulator that remembers its commands and the reports of its player."""

    def __init__(self) -> None:
        super().__init__(period=None)
        self.sent: list[tuple[str, float, Twist]] = []
        self.told: list[Told] = []

    def send(self, robot: str, twist: Twist, at: float) -> None:
        self.sent.append((robot, at, twist))
        super().send(robot, twist, at)


def played(name: str, senses: Iterable[Foreseen] | None = None) -> Watched:
    """The simulator after an example, or after a minute of it; with `senses`, robots sense only these."""
    analysis = read_to_play(next(path for path in REACTING if path.stem == name))
    assert analysis
    simulator = Watched()
    perform(score_of(analysis), simulator, 60.0, simulator.told.append, senses)
    return simulator


def decided(simulator: Watched) -> list[tuple[str, float]]:
    """The robots that reacted, and the beats."""
    return [(each["robot"], each["beat"]) for each in simulator.told if each["type"] == "decided"]


def bumps(simulator: Watched) -> list[str]:
    """The robots that felt a bump, one entry for each bump."""
    sensed = [each for each in simulator.told if each["type"] == "sensed" and each["sense"] == "bump"]
    return sorted(each["robot"] for each in sensed if each["value"])


def walks(simulator: Watched, robot: str) -> list[float]:
    """The beats of `cue.improv` at which a robot that stood or turned starts to walk."""
    found, walking = [], False
    for name, at, twist in simulator.sent:
        if name == robot:
            if twist.x and not walking:
                found.append(round(at / BEAT, 6))
            walking = bool(twist.x)
    return found


@pytest.mark.parametrize(("name", "robots"), [("roamer", {"anna"}), ("passing", {"anna", "bo"})])
def test_robots_that_look_ahead_bump_into_nothing(name: str, robots: set[str]) -> None:
    simulator = played(name)
    assert simulator.warnings() == {}
    assert {robot for robot, _ in decided(simulator)} == robots


def test_the_duet_bumps_once_and_both_answer_at_once() -> None:
    simulator = played("bump")
    assert [*simulator.warnings()] == ["ada"]
    assert bumps(simulator) == ["ada", "bo"]
    (one, moment), (other, same) = decided(simulator)
    assert ({one, other}, moment) == ({"ada", "bo"}, same)
    assert simulator.told[-1]["type"] == "transport"
    assert simulator.told[-1]["state"] == "ended"


def test_dancers_wait_for_the_cue_and_dance_after_it() -> None:
    waiting = played("cue")
    assert decided(waiting) == []
    assert [walks(waiting, robot) for robot in DANCERS] == [[], [], []]

    cues = [Foreseen(Fraction(beat), RobotSense(robot, CUE), True) for beat in ("6.5", "20.25") for robot in DANCERS]
    dancing = played("cue", cues)
    assert decided(dancing) == [(robot, beat) for beat in (6.5, 20.25) for robot in DANCERS]
    # On the next whole beat: the canon of the second scene, and the bow of the third, which all begin together.
    assert [walks(dancing, robot) for robot in DANCERS] == [[7, 21], [9, 21], [11, 21]]
    assert dancing.warnings() == {}
