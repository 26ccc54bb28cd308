"""Requests that a stop makes void by overtaking them, and new robots that a sink gets to know between stops."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from improv_core.ipc.arrivals import Arrival, End, First, Ordered
from improv_core.protocol.limits import SILENCE_LIMIT
from improv_core.protocol.messages import Load, Play
from improv_core.safety.stops import StopFence
from improv_core.score.motion import STILL
from improv_core.score.score import Score
from improv_core.stage.command_queue import SLICE, CommandQueue
from tests.player.test_player import Memory, score
from tests.stage.test_loop import PING, START, errors, perform


def check(heard: str, *void: tuple[str, int | None, bool]) -> None:
    """Check the void requests after messages on the channel of stops, numbered from 1; `lost` if the parent hangs."""
    state = StopFence()
    for number, kind in enumerate(heard.split(), 1):
        state = state.lose() if kind == "lost" else state.hear(kind, number)
    assert [(kind, after, state.voids(kind, after)) for kind, after, _ in void] == list(void)


def test_a_stop_voids_messages_sent_before_it_and_none_after() -> None:
    for stop in ("stop", "pause"):
        check(f"ping {stop} ping", ("load", 1, True), ("load", 2, False), ("load", 3, False), ("resume", 1, True))
        check(f"ping {stop}", ("seek", 1, True), ("cue", 0, True), ("speed", 0, False), ("silence", 0, False))
    check("ping ping", ("load", 0, False))


def test_messages_without_a_count_are_obeyed_in_order() -> None:
    check("stop", ("load", None, False))


def test_messages_from_before_the_parent_hung_stay_void() -> None:
    check("ping ping lost", ("load", 2, True))
    check("ping ping lost ping", ("load", 2, True), ("load", 4, False))


def play(program: str, after: int, robots: str = "") -> Play:
    message: Any = {"type": "load", "generation": 2, "score": {}, "when": "now", "backend": "memory", "after": after}
    load: Load = message
    return Play(load, score(robots + program))


class Slow:
    def __init__(self) -> None:
        self.now = 0.0
        self.met: list[str] = []

    def preload(self, score: Score) -> Iterator[None]:
        for robot in score.parts:
            self.now += 0.004
            self.met.append(robot)
            yield


def all_of(order: CommandQueue) -> list[Ordered | None]:
    found = []
    while (arrival := order.next()) is not None or order.is_busy:
        found.append(arrival)
    return found


def test_robots_are_prepared_in_slices_and_later_messages_wait() -> None:
    sink = Slow()
    order = CommandQueue(sink.preload, lambda: sink.now)
    four = play("a b c d $ forward\n", 0)
    order.add(four)
    order.add({"type": "seek", "beat": 2.0})
    assert order.next() is None
    assert len(sink.met) * 0.004 < SLICE + 0.004
    assert all_of(order) == [None, four, {"type": "seek", "beat": 2.0}]


def test_a_stop_ends_the_meeting_of_robots() -> None:
    sink = Slow()
    order = CommandQueue(sink.preload, lambda: sink.now)
    order.add(play("a b c d $ forward\n", 0))
    later = play("a $ forward\n", 1)
    order.add(later)
    assert order.next() is None
    order.fence = order.fence.hear("stop", 1)
    assert order.next() == later
    assert sink.met == ["a", "b", "a"]


@pytest.mark.parametrize("fence", [StopFence().hear("stop", 5), StopFence().hear_direct("x")], ids=["stop", "direct"])
def test_a_score_that_only_stops_robots_is_never_void(fence: StopFence) -> None:
    """It has a new stage stop the robots of a dead one."""
    order = CommandQueue(Slow().preload, lambda: 0.0)
    order.fence = fence
    order.add(standing := play("", 1))
    assert order.next() == standing


def states(told: list[Any]) -> list[tuple[str, float]]:
    return [(each["state"], round(each["monotonic"] - START, 3)) for each in told if each["type"] == "transport"]


def test_a_score_sent_after_a_stop_is_not_stopped_by_it_although_it_arrives_first() -> None:
    """Two threads read the two pipes."""
    dance: list[tuple[float, Arrival]] = [(0, First(PING, 1)), (0, play("r $ repeat forward\n", 1))]
    save: list[tuple[float, Arrival]] = [(0.2, play("r $ repeat left\n", 3)), (0.21, STOP), (0.22, First(PING, 3))]
    told = perform(Memory(), *dance, *save, (0.4, End()))
    assert states(told) == [("playing", 0), ("stopped", 0.21), ("playing", 0.22), ("stopped", 0.4)]


def test_a_score_sent_once_the_parent_resumes_waits_for_the_ping_before_it() -> None:
    """Two threads read the two pipes, so the score may come first."""
    sink = Memory()
    arrivals: list[tuple[float, Arrival]] = [(0, First(PING, 1)), (0, play("r $ repeat forward\n", 1))]
    resumed: list[tuple[float, Arrival]] = [(2, play("r $ left\n", 2)), (2.01, First(PING, 2)), (2.3, End())]
    told = perform(sink, *arrivals, *resumed)
    assert len(errors(told)) == 1
    playing = [each["monotonic"] for each in told if each["type"] == "transport" and each["state"] == "playing"]
    assert playing == [START, START + 2.01]


STOP = First({"type": "stop"}, 2)


@pytest.mark.parametrize(("after", "moves"), [(1, False), (2, True)])
def test_a_score_that_arrives_after_a_stop_plays_only_if_sent_after_it(after: int, moves: bool) -> None:
    sink = Memory()
    arrivals: list[tuple[float, Arrival]] = [(0, First(PING, 1)), (0.1, STOP), (0.2, play("r $ forward\n", after))]
    perform(sink, *arrivals, (0.3, End()))
    assert any(twist != STILL for _, _, twist in sink.sent) == moves


def test_robots_stop_if_the_parent_hangs_even_if_a_score_is_still_being_read() -> None:
    sink = Memory()
    arrivals: list[tuple[float, Arrival]] = [(0, First(PING, 1)), (0, play("r $ repeat forward\n", 1))]
    behind: list[tuple[float, Arrival]] = [(0.4, PING), (0.9, play("r $ repeat left\n", 1)), (2, End())]
    told = perform(sink, *arrivals, *behind)
    assert len(errors(told)) == 1
    assert max(at for _, at, twist in sink.sent if twist != STILL) < SILENCE_LIMIT + 0.001
