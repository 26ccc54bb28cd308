"""Stops that nobody asked for: robots continue from there if a person asks for that, and never by themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from improv_core.player import events
from improv_core.safety.fault_monitor import RobotNews
from improv_core.safety.fault_rules import FaultBegan, Worst
from improv_core.score.faults import FaultRules
from improv_core.score.motion import Twist
from improv_core.score.score import Safety
from tests.player.test_player import Stage, score

PROGRAM = "beat 60\nr $ left left\n---\nr $ forward forward forward\n"
STOP = "/e_stop"
SILENT = events.Faults([RobotNews("r", FaultBegan("silent", Worst(seconds=1.0)))])


def playing(seconds: float = 3.5, **rest: Any) -> Stage:
    """A real robot in the middle of the second movement of its second scene."""
    stage = Stage()
    stage.sink.real = True
    stage.perform(replace(score(PROGRAM), safety=Safety(stop=STOP, faults=FaultRules({"silent": "stop"}))), **rest)
    stage.run(seconds)
    return stage


def replaced() -> Stage:
    """A new stage after the stage of that robot has died there."""
    return playing(stood={"beat": 3.5, "monotonic": 1000.0})


def offered(stage: Stage) -> Any:
    return stage.transports[-1].get("resumes")


@pytest.mark.parametrize(
    "event",
    [
        None,
        {"type": "stop", "unasked": True},
        events.Halted(),
        events.Halted(counts=True),
        events.Stalled(0.6),
        events.Overloaded(),
        SILENT,
    ],
    ids=["dead stage", "another stage", "machine slept", "parent hung", "late", "too slow", "fault"],
)
@pytest.mark.parametrize(("place", "beat"), [("scene", 2.0), ("beat", 3.5)])
def test_after_a_stop_that_nobody_asked_for_a_person_has_robots_continue(event: Any, place: str, beat: float) -> None:
    stage = playing() if event else replaced()
    if event:
        stage.player.take(event, stage.now)
    assert stage.states[-1] == "stopped"
    assert offered(stage) == {"scene": 2.0, "beat": 3.5}
    stage.sink.sent.clear()
    stage.run(60)
    assert [twist for _, _, twist in stage.sink.sent if twist != Twist()] == [], "nothing moves by itself"
    stage.ask("resume", beat=offered(stage)[place])
    assert (stage.states[-1], stage.transports[-1]["beat"], offered(stage)) == ("playing", beat, None)
    stage.run(5 - beat - 0.1)
    assert stage.sink.sent[-1][2] == Twist(2)
    stage.run(1)
    assert stage.states[-1] == "ended"


Asked = Callable[[Stage], None]


@pytest.mark.parametrize(
    "ask",
    [
        lambda stage: stage.ask("stop"),
        lambda stage: stage.ask("stop", by="osc"),
        lambda stage: stage.player.take(events.EmergencyStop(STOP, True), stage.now),
    ],
    ids=["a person", "a controller", "an emergency stop"],
)
@pytest.mark.parametrize("before", [False, True])
def test_a_stop_that_somebody_asked_for_offers_nothing(ask: Asked, before: bool) -> None:
    """It also ends an earlier offer."""
    stage = playing()
    if before:
        stage.player.take(events.Halted(), stage.now)
    ask(stage)
    assert (stage.states[-1], offered(stage)) == ("stopped", None)


@pytest.mark.parametrize("asked", [{"by": "ros"}, {"by": "osc"}, {"pressed": True}])
@pytest.mark.parametrize("died", [False, True])
def test_only_a_person_continues_and_only_once_emergency_stops_are_released(asked: dict[str, Any], died: bool) -> None:
    stage = replaced() if died else playing()
    stage.player.take(events.Halted(), stage.now)
    if asked.get("pressed"):
        stage.player.take(events.EmergencyStop(STOP, True), stage.now)
    stage.sink.sent.clear()
    stage.ask("resume", beat=3.5, **({"by": asked["by"]} if "by" in asked else {}))
    stage.run(5)
    assert stage.states[-1] == "stopped"
    assert {twist for _, _, twist in stage.sink.sent} <= {Twist()}


def test_a_new_stage_that_only_stops_robots_blames_no_emergency_stop_that_is_on() -> None:
    stage = Stage()
    stage.sink.real = True
    stage.ask("pressed", topics=[STOP], count=1)
    dance = score(PROGRAM)
    stage.perform(replace(dance, parts={"r": replace(dance.parts["r"], scenes=())}))
    stage.run(5)
    assert (stage.states[-1], stage.lines) == ("stopped", [])
    assert {twist for _, _, twist in stage.sink.sent} == {Twist()}


def test_a_dance_that_has_yet_to_begin_is_not_continued() -> None:
    stage = Stage()
    stage.sink.real = stage.sink.resets = True
    stage.load(PROGRAM)
    stage.run(1)
    stage.player.take(events.Halted(), stage.now)
    assert (stage.states[-1], offered(stage)) == ("stopped", None)
