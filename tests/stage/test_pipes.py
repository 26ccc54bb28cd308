"""The stage's messages to its parent: what overtakes what."""

from __future__ import annotations

import threading

from improv_core.stage.messages import FromStage, Pong, Sent
from improv_core.stage.pipes import Outbox


def sent(robot: str) -> Sent:
    return {"type": "sent", "robot": robot, "twist": [0.0, 0.0, 0.0, 0.0], "wall": 0}


def pong(number: int) -> Pong:
    return {"type": "pong", "number": number}


def test_an_answer_to_a_ping_overtakes_everything_the_parent_has_not_read() -> None:
    outbox = Outbox()
    for message in (sent("a"), sent("b"), pong(1), sent("c"), pong(2), None):
        outbox.put(message)
    assert [outbox.get() for _ in range(6)] == [pong(1), pong(2), sent("a"), sent("b"), sent("c"), None]


def test_an_answer_wakes_anything_waiting_for_a_message() -> None:
    outbox = Outbox()
    got: list[FromStage | None] = []
    waiting = threading.Thread(target=lambda: got.extend(outbox.get() for _ in range(2)), daemon=True)
    waiting.start()
    outbox.put(pong(1))
    outbox.put(sent("a"))
    waiting.join(60)
    assert got == [pong(1), sent("a")]
