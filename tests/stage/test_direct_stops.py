"""Stops that come straight to a stage: no request from before one plays, even if the parent sends it later."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from improv_core.ipc.arrivals import DirectStop, End, First, Lost
from improv_core.protocol.commands import VOIDED_BY_STOP, Stop
from improv_core.safety.stage_stops import StageSocket, stop_stages
from improv_core.safety.stops import MAX_DIRECT, StopFence
from improv_core.score.motion import STILL
from tests.player.test_player import Memory
from tests.safety.stages import die
from tests.session.story import at
from tests.stage.test_command_queue import play, states
from tests.stage.test_loop import PING, START, Event, perform, zeros

X: Any = {"type": "stop", "direct": "x"}
DANCE: list[tuple[float, Event]] = [(0, First(PING, 1)), (0, play("r $ repeat forward\n", 1))]


class Direct:
    """A stop that comes straight to a stage, and whether its sink stands each time it is confirmed."""

    def __init__(self, sink: Memory, stop: Any = X) -> None:
        self.arrival = DirectStop(
            stop, lambda: self.confirmed.append(all(twist == STILL for _, _, twist in sink.sent[-1:]))
        )
        self.confirmed: list[bool] = []


def from_parent(number: int, stop: Any = X) -> First:
    return First(stop, number)


def check(*arrivals: tuple[float, Any], told: list[tuple[str, float]], reports: int = 1) -> None:
    """Check the states of a stage that dances until it gets a direct stop at 0.1 s, and how often it reports that."""
    sink = Memory()
    direct = Direct(sink)
    begin: list[tuple[float, Any]] = [*DANCE, (0.1, direct.arrival)]
    said = perform(sink, *begin, *arrivals, (0.4, End()))
    assert states(said) == [("playing", 0), ("stopped", 0.1), *told]
    assert direct.confirmed == [True]
    assert [each["command"] for each in said if each["type"] == "request"] == [{**X, "at": START + 0.1}] * reports
    assert all(each["type"] != "obeyed" for each in said), "who asked knows it already"


@pytest.mark.parametrize("request_", sorted(VOIDED_BY_STOP))
@pytest.mark.parametrize("after", [1, 2, None])
def test_a_request_is_void_until_the_parent_has_sent_the_stop(request_: str, after: int | None) -> None:
    """The parent may ping before it learns of the stop, so that the number of a request says nothing."""
    state = StopFence().hear("ping", 2).hear_direct("x")
    assert state.voids(request_, after)
    state = state.settle("x").hear("stop", 3)
    assert [state.voids(request_, number) for number in (2, 3)] == [True, False]


def test_each_of_several_stops_has_to_come_from_the_parent() -> None:
    state = StopFence().hear_direct("x").hear_direct("y").settle("y").hear("stop", 1)
    assert state.voids("load", 1)
    assert [state.has(each) for each in "xyz"] == [True, True, False]
    assert not state.settle("x").voids("load", 1)


def test_a_stop_that_comes_late_voids_nothing_after_it_has_come_from_the_parent() -> None:
    state = StopFence().settle("x").hear("stop", 1).hear_direct("x")
    assert not state.voids("load", 1)


def test_a_flood_of_stops_keeps_the_fence_closed_and_is_forgotten() -> None:
    state = StopFence()
    for number in range(3 * MAX_DIRECT):
        state = state.hear_direct(str(number))
    assert len(state.direct) == MAX_DIRECT
    assert state.voids("load", 0)
    for number in range(3 * MAX_DIRECT):
        state = state.settle(str(number))
    assert not state.voids("load", 0)
    assert len(state.known) == MAX_DIRECT


def test_a_save_from_before_a_stop_of_which_the_parent_has_not_heard_does_not_play() -> None:
    check((0.2, First(PING, 2)), (0.2, play("r $ repeat left\n", 2)), told=[])


def test_a_save_after_a_stop_plays_as_soon_as_the_parent_has_sent_the_stop() -> None:
    check(
        (0.2, from_parent(2)),
        (0.3, play("r $ repeat left\n", 2)),
        told=[("stopped", 0.2), ("playing", 0.3), ("stopped", 0.4)],
    )


def test_a_save_after_a_stop_that_arrives_before_the_stop_from_the_parent_waits_for_it() -> None:
    """Two threads read the two pipes."""
    check(
        (0.2, play("r $ repeat left\n", 2)),
        (0.3, from_parent(2)),
        told=[("stopped", 0.3), ("playing", 0.3), ("stopped", 0.4)],
    )


def test_a_stop_is_obeyed_once_however_often_it_comes() -> None:
    sink = Memory()
    again, late = Direct(sink), Direct(sink)
    check((0.15, again.arrival), (0.2, from_parent(2)), (0.3, late.arrival), told=[("stopped", 0.2)])


def test_a_stop_is_reported_with_the_time_at_which_somebody_asked_for_it() -> None:
    sink = Memory()
    asked = {**X, "at": START + 0.05}
    said = perform(sink, *DANCE, (0.1, Direct(sink, asked).arrival), (0.4, End()))
    assert [each["command"] for each in said if each["type"] == "request"] == [asked]


def test_a_stop_that_the_parent_was_faster_to_send_stops_nothing_that_plays_after_it() -> None:
    sink = Memory()
    late = Direct(sink)
    save: list[tuple[float, Any]] = [(0.1, from_parent(2)), (0.2, play("r $ repeat left\n", 2))]
    said = perform(sink, *DANCE, *save, (0.3, late.arrival), (0.4, End()))
    assert states(said) == [("playing", 0), ("stopped", 0.1), ("playing", 0.2), ("stopped", 0.4)]
    assert len(late.confirmed) == 1
    assert all(each["type"] != "request" for each in said)


def test_a_stop_ends_the_wait_of_a_pause_that_was_sent_ahead() -> None:
    pause: Any = {"type": "pause", "at": START + 0.3}
    sink = Memory()
    arrivals: list[tuple[float, Any]] = [*DANCE, (0.05, First(pause, 2)), (0.1, Direct(sink).arrival)]
    assert states(perform(sink, *arrivals, (0.4, End()))) == [("playing", 0), ("stopped", 0.1)]
    assert zeros(sink, "r")[0] == 0.1


def test_a_lost_score_is_not_requested_again_before_the_parent_has_sent_the_stop() -> None:
    check((0.2, First(PING, 2)), (0.2, Lost(3, 2)), told=[])


@pytest.fixture
def show() -> Iterator[Path]:
    with TemporaryDirectory(dir="/tmp") as folder:
        yield Path(folder, "7-abc")


def test_a_stage_in_place_of_a_dead_one_answers_once_it_has_stopped_or_moves_its_robots(show: Path) -> None:
    die(show, "ros")
    taken: queue.SimpleQueue[Stop] = queue.SimpleQueue()
    new = StageSocket(show, "ros", lambda stop, answer: taken.put(stop))
    for message in (at("stopped", 0, 0.0, 0.0), at("waiting", 5, 0.0, 0.0)):
        new.hear(message)
        assert new._server is None, message
    new.hear(at("ended", 5, 0.0, 0.0))
    assert stop_stages(show, X, 0.0) == ["the real robots"], "it has not obeyed yet"
    assert taken.get(timeout=60) == X
    new.close()
