"""The input of a stage, and its messages to its parent: urgent messages overtake others."""

from __future__ import annotations

import io
import os
from typing import Any

import pytest

from improv_core.ipc.arrivals import Arrival, End, First, UrgentQueue
from improv_core.protocol.messages import Pong, Sent
from improv_core.safety.heartbeat import Parent
from improv_core.stage import stdio
from improv_core.stage.stdio import TOO_LONG, Outbox, put, read_arrivals, read_stops


def sent(robot: str) -> Sent:
    return {"type": "sent", "robot": robot, "twist": [0.0, 0.0, 0.0, 0.0], "wall": 0}


def pong(number: int) -> Pong:
    return {"type": "pong", "number": number}


def test_an_answer_to_a_ping_overtakes_everything_the_parent_has_not_read() -> None:
    outbox: Outbox = UrgentQueue()
    for message in (sent("a"), sent("b"), pong(1), sent("c"), pong(2)):
        put(outbox, message)
    outbox.put(None)
    assert [outbox.get() for _ in range(6)] == [pong(1), pong(2), sent("a"), sent("b"), sent("c"), None]


def read(monkeypatch: pytest.MonkeyPatch, text: bytes) -> list[Arrival]:
    """Return the arrivals if standard input has this text, of which no line may have more than 40 bytes."""
    monkeypatch.setattr(stdio, "LONGEST_LINE", 40)
    monkeypatch.setattr(stdio, "open", lambda *_, **__: io.BytesIO(text), raising=False)
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    read_arrivals(inbox, Parent(), lambda message: None)
    return everything(inbox)


def everything(inbox: UrgentQueue[Arrival]) -> list[Arrival]:
    arrivals: list[Arrival] = []
    while not arrivals or not isinstance(arrivals[-1], End):
        arrivals.append(inbox.get(timeout=0.0))
    return arrivals


def test_a_line_that_is_too_long_is_a_score_that_cannot_be_played_and_the_next_one_is_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stop: Any = {"type": "stop"}
    assert read(monkeypatch, b"x" * 100 + b'\n{"type": "stop"}\n') == [TOO_LONG, stop, End()]
    assert read(monkeypatch, b"x" * 100) == [TOO_LONG, End()]
    assert read(monkeypatch, b'{"type": "stop"}') == [End()], "the end came in the middle of a line"


def test_other_messages_on_the_channel_of_stops_end_the_stage() -> None:
    reading, writing = os.pipe()
    os.write(writing, b'{"type": "pause", "number": 3}\n{"type": "load"}\n')
    os.close(writing)
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    read_stops(reading, inbox, Parent(), lambda message: None)
    os.close(reading)
    first, end = everything(inbox)
    assert isinstance(first, First)
    assert isinstance(end, End)
    assert end.problem.startswith("the stage can't read stops: ")
