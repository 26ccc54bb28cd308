"""The far end of a link: when a stage beside it counts as hung, at times that the tests choose."""

from __future__ import annotations

import json
import time

import pytest

from improv_core.hosts.far import FarEnd, FarOutbox
from improv_core.hosts.frames import LinkFrame
from improv_core.protocol.limits import HANG_LIMIT, LOADING_LIMIT
from improv_core.safety.heartbeat import LOOK_PERIOD

READY, PLAYS = b'{"type": "ready", "sink": "ros"}', b'{"type": "transport", "state": "playing"}'


class Link:
    """A far end whose stage plays, and answers only what the test lets it."""

    def __init__(self, *said: bytes) -> None:
        self.far = FarEnd(FarOutbox())
        self.now = time.monotonic()
        for line in said or (READY, PLAYS):
            self.far.hear(line, self.now)

    def exceeded(self, seconds: float) -> float | None:
        """Return the limit that the stage exceeds within this many seconds, and stop there."""
        for _ in range(round(seconds / LOOK_PERIOD)):
            self.now += LOOK_PERIOD
            if limit := self.far.exceeded(self.now):
                return limit
        return None

    def ping(self, number: int, letter: str = "s") -> None:
        self.far.obey(LinkFrame(letter, json.dumps({"type": "ping", "number": number}).encode()))

    def pong(self, number: int) -> None:
        self.far.hear(json.dumps({"type": "pong", "number": number}).encode(), self.now)


def test_a_stage_that_does_not_answer_hangs() -> None:
    link = Link()
    link.ping(1)
    assert link.exceeded(HANG_LIMIT - LOOK_PERIOD) is None
    assert link.exceeded(3 * LOOK_PERIOD) == HANG_LIMIT


@pytest.mark.parametrize("answered", [False, True], ids=["never pinged", "answered"])
def test_a_stage_does_not_hang_because_its_link_is_silent(answered: bool) -> None:
    link = Link()
    if answered:
        link.ping(1)
        link.pong(1)
    assert link.exceeded(60) is None
    link.ping(2)
    assert link.exceeded(HANG_LIMIT - LOOK_PERIOD) is None
    assert link.exceeded(3 * LOOK_PERIOD) == HANG_LIMIT


def test_before_it_is_ready_it_may_take_as_long_as_its_parent_allows() -> None:
    link = Link(PLAYS)
    link.ping(1)
    assert link.exceeded(60) is None
    link.far.hear(READY, link.now)
    assert link.exceeded(HANG_LIMIT + 2 * LOOK_PERIOD) == HANG_LIMIT


def test_a_score_may_take_long_until_the_ping_behind_it_is_answered() -> None:
    link = Link()
    link.far.obey(LinkFrame("l", b""))
    link.ping(7)
    assert link.exceeded(LOADING_LIMIT - LOOK_PERIOD) is None
    link.ping(8, "M")
    link.pong(7)
    assert link.exceeded(LOADING_LIMIT - LOOK_PERIOD) is None
    assert link.exceeded(3 * LOOK_PERIOD) == LOADING_LIMIT
    link.pong(8)
    link.ping(9)
    assert link.exceeded(HANG_LIMIT + 2 * LOOK_PERIOD) == HANG_LIMIT
