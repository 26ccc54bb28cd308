"""Several stages do the same at the same instant: what they are asked for comes before it takes effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from improv_core.score.motion import STILL
from improv_core.score.score import Host, Score
from improv_core.stage.arrivals import End, First, Play
from improv_core.stage.limits import MOST_AHEAD
from improv_core.stage.messages import FromStage
from tests.stage.test_loop import PING, START, Event, FromRos, errors, load, perform, zeros
from tests.stage.test_player import Memory

DANCE = "beat 60\nr $ repeat forward\n"


def moments(told: list[FromStage]) -> list[tuple[str, float, float]]:
    """Each state that was told, when, in seconds from the start, and at which beat."""
    return [
        (each["state"], round(each["monotonic"] - START, 9), round(each["beat"], 9))
        for each in told
        if each["type"] == "transport"
    ]


def check(*arrivals: tuple[float, Event], told: list[tuple[str, float, float]]) -> None:
    assert moments(perform(Memory(), (0, load(DANCE)), *arrivals, (9, End()))) == [("playing", 0, 0), *told]


def first(kind: str, number: int, **rest: Any) -> Event:
    message: Any = {"type": kind, "number": number, **rest}
    return First(message, number)


def after(count: int, kind: str, **rest: Any) -> Any:
    return {"type": kind, "after": count, **rest}


def test_what_comes_early_takes_effect_at_its_time() -> None:
    check(
        (1, {"type": "speed", "factor": 2.0, "at": START + 1.5}),
        (3, {"type": "stop"}),
        told=[("playing", 1.5, 1.5), ("stopped", 3, 4.5)],
    )


def test_what_comes_next_waits_for_what_comes_early() -> None:
    check(
        (1, {"type": "seek", "beat": 8.0, "at": START + 1.5}),
        (1.1, {"type": "speed", "factor": 2.0, "at": START + 1.1}),
        (3, {"type": "stop"}),
        told=[("playing", 1.5, 8), ("playing", 1.5, 8), ("stopped", 3, 11)],
    )


def test_a_time_that_is_too_far_ahead_counts_as_now() -> None:
    late = START + 1 + MOST_AHEAD + 0.1
    check(
        (1, {"type": "seek", "beat": 8.0, "at": late}),
        (3, {"type": "stop"}),
        told=[("playing", 1, 8), ("stopped", 3, 10)],
    )


def test_a_stop_makes_void_what_waits_for_its_time() -> None:
    check(
        (1, first("ping", 1)),
        (1, after(1, "seek", beat=8.0, at=START + 1.5)),
        (1.1, first("pause", 2, at=START + 1.4)),
        (1.2, first("stop", 3)),
        told=[("stopped", 1.2, 1.2)],
    )


def test_a_pause_that_comes_early_takes_effect_at_its_time_and_before_what_was_asked_for_after_it() -> None:
    check(
        (1, first("pause", 1, at=START + 1.5)),
        (1.1, after(1, "resume", at=START + 1.1)),
        (3, first("stop", 2)),
        told=[("paused", 1.5, 1.5), ("playing", 1.5, 1.5), ("stopped", 3, 3)],
    )


def loaded(play: Play, **rest: Any) -> Play:
    message: Any = {**play.load, **rest}
    return replace(play, load=message)


@pytest.mark.parametrize(("when", "at", "begins"), [("beat", 1.3, 2), ("beat", 2.3, 3), ("now", 1.3, 1.3)])
def test_a_score_takes_over_at_the_first_beat_after_its_time(when: str, at: float, begins: float) -> None:
    save = loaded(load("beat 60\nr $ repeat left\n"), generation=2, when=when, at=START + at)
    sink = Memory()
    told = perform(sink, (0, load(DANCE)), (0.9, save), (4, End()))
    assert moments(told)[1] == ("playing", begins, begins)
    assert next(at for _, at, twist in sink.sent if twist.yaw) == pytest.approx(begins)


def test_a_score_that_is_opened_begins_exactly_then() -> None:
    armed = loaded(load(DANCE), arming={})
    told = perform(Memory(), (0, armed), (1, {"type": "resume", "at": START + 1.25}), (4, End()))
    assert ("playing", 1.25, 0) in moments(told)


def far(play: Play, **rest: Any) -> Play:
    """A score in which the robot `s` is on another machine."""
    parts = {**play.score.parts, "s": replace(play.score.parts["s"], host=Host("pi"))}
    return loaded(replace(play, score=Score(play.score.tempo, parts)), **rest)


PAIR = "beat 60\nr $ forward\ns $ forward forward\n---\nr s $ left\n"


@pytest.mark.parametrize(("here", "ours"), [("", "r"), ("pi", "s")])
def test_a_stage_knows_which_robots_others_move_and_begins_scenes_with_all(here: str, ours: str) -> None:
    dance = far(load(PAIR))
    told = dance.score.on(here)
    assert {name for name, part in told.parts.items() if not part.elsewhere} == {ours}
    assert told.scene_begins == dance.score.scene_begins


def test_robots_of_a_patient_host_dance_on_while_nothing_comes() -> None:
    sink = Memory()
    patient = far(load(PAIR.replace("forward", "repeat forward", 1)), here="", patience=3.0)
    told = perform(sink, (0, PING), (0, patient), (0.1, PING), (9, End()))
    assert errors(told) == []
    assert [each for each in told if each["type"] == "deserted"] == [{"type": "deserted", "seconds": 3.0}]
    assert zeros(sink, "r") == [3.1, 3.15, 3.2]


def test_what_was_sent_before_the_silence_does_not_play_when_it_arrives_after_it() -> None:
    sink = Memory()
    patient = far(load(PAIR), here="", patience=1.0)
    perform(
        sink,
        (0, First(PING, 1)),
        (0, loaded(patient, after=1)),
        (5, FromRos(loaded(patient, after=1, generation=2))),
        (9, End()),
    )
    assert max(at for _, at, twist in sink.sent if twist != STILL) < 1.05
