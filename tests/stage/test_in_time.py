"""Several stages do the same at the same instant: requests arrive before they take effect."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from improv_core.ipc.arrivals import End, First
from improv_core.protocol.limits import MAX_AHEAD
from improv_core.protocol.messages import FromStage, Play
from improv_core.score.motion import STILL
from improv_core.score.score import Host, Score
from tests.player.test_player import Memory
from tests.stage.test_loop import PING, START, Event, FromRos, errors, load, perform, zeros

DANCE = "beat 60\nr $ repeat forward\n"


def moments(told: list[FromStage]) -> list[tuple[str, float, float]]:
    """Each reported state, its time in seconds from the start, and its beat."""
    return [
        (each["state"], round(each["monotonic"] - START, 9), round(each["beat"], 9))
        for each in told
        if each["type"] == "transport"
    ]


def check(*arrivals: tuple[float, Event], told: list[tuple[str, float, float]], late: float = 0.0) -> None:
    assert moments(perform(Memory(), (0, load(DANCE)), *arrivals, (9, End()), late=late)) == [("playing", 0, 0), *told]


def first(kind: str, number: int, **rest: Any) -> Event:
    message: Any = {"type": kind, "number": number, **rest}
    return First(message, number)


def after(count: int, kind: str, **rest: Any) -> Any:
    return {"type": kind, "after": count, **rest}


def test_an_early_message_takes_effect_at_its_time_even_if_the_stage_wakes_late() -> None:
    check(
        (1, {"type": "speed", "factor": 2.0, "at": START + 1.5}),
        (2.1, first("pause", 1, at=START + 2.5)),
        (2.2, after(1, "resume", at=START + 3.5)),
        (5, first("stop", 2)),
        told=[("playing", 1.5, 1.5), ("paused", 2.5, 3.5), ("playing", 3.5, 3.5), ("stopped", 5, 6.5)],
        late=0.008,
    )


def test_a_stop_counts_from_its_arrival() -> None:
    check((1.02, {"type": "stop", "at": START + 1.01}), told=[("stopped", 1.02, 1.02)])


def test_the_next_message_waits_for_an_early_one() -> None:
    check(
        (1, {"type": "seek", "beat": 8.0, "at": START + 1.5}),
        (1.1, {"type": "speed", "factor": 2.0, "at": START + 1.1}),
        (3, {"type": "stop"}),
        told=[("playing", 1.5, 8), ("playing", 1.5, 8), ("stopped", 3, 11)],
    )


def test_a_time_that_is_too_far_ahead_counts_as_now() -> None:
    late = START + 1 + MAX_AHEAD + 0.1
    check(
        (1, {"type": "seek", "beat": 8.0, "at": late}),
        (3, {"type": "stop"}),
        told=[("playing", 1, 8), ("stopped", 3, 10)],
    )


def test_a_stop_drops_messages_that_wait_for_their_time() -> None:
    check(
        (1, first("ping", 1)),
        (1, after(1, "seek", beat=8.0, at=START + 1.5)),
        (1.1, first("pause", 2, at=START + 1.4)),
        (1.2, first("stop", 3)),
        told=[("stopped", 1.2, 1.2)],
    )


def test_an_early_pause_takes_effect_at_its_time_and_before_later_requests() -> None:
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
LONG_PAIR = PAIR.replace("forward", "repeat forward", 1)


@pytest.mark.parametrize(("here", "ours"), [("", "r"), ("pi", "s")])
def test_a_stage_knows_which_robots_others_move_and_begins_scenes_with_all(here: str, ours: str) -> None:
    dance = far(load(PAIR))
    told = dance.score.on(here)
    assert {name for name, part in told.parts.items() if not part.elsewhere} == {ours}
    assert told.scene_begins == dance.score.scene_begins


def test_robots_of_a_patient_host_dance_on_while_nothing_comes() -> None:
    sink = Memory()
    patient = far(load(LONG_PAIR), here="", patience=3.0)
    told = perform(sink, (0, PING), (0, patient), (0.1, PING), (9, End()))
    assert errors(told) == []
    assert [each for each in told if each["type"] == "deserted"] == [{"type": "deserted", "seconds": 3.0}]
    assert zeros(sink, "r") == [3.1, 3.15, 3.2]


def test_a_message_from_before_the_silence_does_not_play_after_it() -> None:
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


def beat_at_the_end(*arrivals: tuple[float, Event], **rest: str) -> float:
    """The beat of a dance after 5 s. If `here` is given, some of its robots are on other machines."""
    dance = loaded(far(load(LONG_PAIR)), **rest)
    return moments(perform(Memory(), (0, dance), *arrivals, (5, {"type": "stop"}), (9, End())))[-1][2]


LATE_RESUME: list[tuple[float, Event]] = [(2, {"type": "pause"}), (4.2, {"type": "resume", "at": START + 4.0})]


@pytest.mark.parametrize(
    ("arrivals", "beat"),
    [
        ([(2.2, {"type": "speed", "factor": 2.0, "at": START + 2.0})], 2 + 3 * 2),
        ([(2.2, {"type": "seek", "beat": 1.0, "at": START + 2.0})], 1 + 3),
        (LATE_RESUME, 2 + 1),
    ],
)
def test_a_stage_that_hears_late_continues_from_where_the_others_are(
    arrivals: list[tuple[float, Event]], beat: float
) -> None:
    assert beat_at_the_end(*arrivals, here="") == beat


def test_a_stage_that_plays_alone_skips_nothing_if_it_hears_late() -> None:
    assert beat_at_the_end(*LATE_RESUME) == pytest.approx(2 + 1 - 0.15, abs=0.001)


def test_a_stage_that_hears_late_that_all_begin_begins_where_the_others_are() -> None:
    armed = far(load(PAIR), here="", arming={})
    told = perform(Memory(), (0, armed), (1.2, {"type": "resume", "at": START + 1}), (4, End()))
    assert [each for each in moments(told) if each[0] == "playing"] == [("playing", 1.2, 0.2)]


@pytest.mark.parametrize(("comes", "begins"), [(1.9, 2), (2.1, 2), (2.6, 3)])
def test_a_score_that_comes_late_takes_over_when_it_did_in_other_stages(comes: float, begins: float) -> None:
    dance = far(load(LONG_PAIR), here="")
    save = loaded(far(load(LONG_PAIR.replace("forward", "left", 1)), here=""), generation=2, when="beat")
    told = perform(Memory(), (0, dance), (comes, loaded(save, at=START + 1.8)), (5, End()))
    assert moments(told)[1] == ("playing", begins, begins)


def test_an_edited_robot_gets_nothing_of_its_old_part_at_the_takeover() -> None:
    programs = [f"beat 75\nr $ repeat ({phrase})\n" for phrase in ("forward left", "left forward")]
    for pause in range(1, 60):  # so many different sums of times
        dance, edit, undo = (load(programs[number % 2]) for number in range(3))
        told = perform(
            sink := Memory(),
            (0, dance),
            (1, {"type": "pause"}),
            (1 + pause / 60, {"type": "resume"}),
            (2.5, {"type": "speed", "factor": 1.25}),
            (4, loaded(edit, generation=2, when="beat")),
            (6, loaded(undo, generation=3, when="beat")),
            (9, End()),
        )
        takeovers = [at for _, at, _ in moments(told) if 4 < at < 9]
        sent = [sum(abs(each[1] - at) < 2e-7 for each in sink.sent) for at in takeovers]
        assert sent == [1, 1], pause


OPEN = "beat 60\nr $ forward\ns $ until near repeat left\n---\nr $ left forward\n"


def near_of_s(beat: float) -> Any:
    """The message about a sense of the robot `s`, from the stage elsewhere that moves it."""
    sensed = {"type": "sensed", "robot": "s", "sense": "near", "value": True, "generation": 1}
    return {**sensed, "beat": beat, "performed": beat, "wall": 0}


@pytest.mark.parametrize(("comes", "begins"), [(2.5, 3), (3.2, 4)])
def test_a_sense_of_a_robot_elsewhere_ends_a_scene_at_the_next_beat_and_is_no_stall(
    comes: float, begins: float
) -> None:
    told = perform(Memory(), (0, far(load(OPEN), here="")), (comes, near_of_s(2.3)), (9, End()))
    assert moments(told)[1:] == [("playing", begins, begins), ("ended", begins + 2, begins + 2)]
    assert errors(told) == []


def test_joining_late_is_no_stall() -> None:
    joins = loaded(far(load(DANCE.replace("r", "r s", 1)), here=""), entry={"beat": 1.0, "monotonic": START + 1})
    told = perform(Memory(), (2.5, joins), (9, End()))
    assert errors(told) == []


def test_a_save_on_a_dance_that_has_stopped_here_is_requested_whole_and_moves_nobody() -> None:
    sink = Memory()
    save = loaded(load("beat 60\nr $ repeat left\n"), generation=2, when="beat", here="")
    told = perform(sink, (0, load(DANCE)), (1, {"type": "stop"}), (2, save), (4, End()))
    assert [each for each in told if each["type"] == "lacks"] == [{"type": "lacks", "generation": 2}]
    assert max(at for _, at, twist in sink.sent if twist != STILL) < 1.05


def test_deserted_robots_stand_until_their_parent_sends_everything_again_and_are_reported() -> None:
    dance = far(load(LONG_PAIR), here="", patience=0.5)
    told = perform(
        Memory(),
        (0, PING),
        (0, dance),
        (2, PING),
        (2.0, {"type": "seek", "beat": 1.0}),
        (2.1, {"type": "resume"}),
        (2.2, loaded(dance, generation=2, when="now")),
        (2.4, loaded(dance, generation=2, entry={"beat": 3.0, "monotonic": START + 2.5})),
        (2.8, End()),
    )
    states = [(each["state"], each.get("deserted", False)) for each in told if each["type"] == "transport"]
    assert states == [("playing", False), ("stopped", True), ("playing", False), ("stopped", False)]
