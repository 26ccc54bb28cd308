"""The queue of messages to a stage: urgent ones overtake others."""

from __future__ import annotations

import queue
from dataclasses import replace

import pytest

from improv_core.ipc.arrivals import MAX_SENSED, UrgentQueue
from improv_core.protocol.output import Edge, StopButton
from improv_core.score.senses import RobotSense


def order(*kinds: str) -> str:
    """Return the order in which messages come out; capitals stand for other items, such as a score that has been
    read."""
    waiting: UrgentQueue[object] = UrgentQueue()
    for kind in kinds:
        waiting.put(kind if kind.isupper() else {"type": kind})
    found: list[str] = []
    while True:
        try:
            each = waiting.get(timeout=0)
        except queue.Empty:
            return " ".join(found)
        found.append(each["type"] if isinstance(each, dict) else str(each))


@pytest.mark.parametrize(
    ("put", "got"),
    [
        ("seek speed pause", "seek speed pause"),
        ("seek speed ping", "ping seek speed"),
        ("seek ping speed ping", "ping ping seek speed"),
        ("speed silence stop", "stop speed silence"),
        ("seek ping stop ping", "ping stop ping"),
        # Requests from before a stop are not obeyed after it; later ones are.
        ("seek pause resume speed stop seek", "stop speed seek"),
        ("held seek released held", "released seek held"),
        # Scores stay where they are, and so does what belongs to them.
        ("seek load seek stop ping", "seek load stop ping"),
        ("load stop load seek ping", "load stop load ping seek"),
        ("seek READING PLAY seek stop", "seek READING PLAY stop"),
        ("seek END", "seek END"),
    ],
)
def test_urgent_messages_overtake_the_others(put: str, got: str) -> None:
    assert order(*put.split()) == got


def test_edges_overtake_everything_else_and_stay_in_order() -> None:
    waiting: UrgentQueue[object] = UrgentQueue()
    seek, stop, score = {"type": "seek"}, {"type": "stop"}, "SCORE"
    on, off = Edge(StopButton("/e_stop"), True, 1.0), Edge(StopButton("/e_stop"), False, 2.0)
    for item in (score, seek, on, stop, off):
        waiting.put(item)
    assert [waiting.get() for _ in range(4)] == [on, off, score, stop]


def test_sensed_changes_overtake_everything_but_a_stop() -> None:
    waiting: UrgentQueue[object] = UrgentQueue()
    seek, stop = {"type": "seek"}, {"type": "stop"}
    pressed, near = Edge(StopButton("/e_stop"), True, 1.0), Edge(RobotSense("a", "near"), True, 2.0)
    far = replace(near, value=False)
    for item in (seek, near, pressed):
        waiting.put(item)
    assert waiting.get() == pressed
    waiting.put(far)
    assert waiting.get() == near
    waiting.put(stop)
    assert [waiting.get() for _ in range(2)] == [stop, far]


def test_sensors_that_flood_hold_up_nothing_and_become_few() -> None:
    """Their latest changes are kept, so no touch is missed and no reaction comes late."""
    waiting: UrgentQueue[object] = UrgentQueue()
    touch = Edge(RobotSense("a", "bump"), True, 0.5)
    flood = [Edge(RobotSense("b", "near"), at % 2 == 0, float(at)) for at in range(2 * MAX_SENSED)]
    for item in (flood[0], touch, *flood[1:], "SCORE", {"type": "ping"}):
        waiting.put(item)
    assert [waiting.get() for _ in range(5)] == [touch, "SCORE", flood[-2], {"type": "ping"}, flood[-1]]
    with pytest.raises(queue.Empty):
        waiting.get(timeout=0)
