"""Limits of a page's requests, on a clock that the tests advance."""

from __future__ import annotations

import time
from collections.abc import Callable

from improv_core.ipc.rate_limit import MAX_MESSAGES, Flood, Throttle
from improv_core.protocol.commands import PageRequest


class Turned:
    """A throttle, the requests that it has passed on, and its work for later."""

    def __init__(self) -> None:
        self.passed: list[str] = []
        self._later: list[Callable[[], None]] = []
        self._throttle = Throttle(self._pass, lambda delay, do: self._later.append(do))

    def ask(self, *requests: str | float) -> str:
        """Send all of these at one time, a beat being a seek; return those that are passed on at once."""
        for each in requests:
            self._throttle.take(REQUESTS[each] if isinstance(each, str) else {"type": "seek", "beat": each})
        return self._taken()

    def turn(self) -> str:
        """Return the requests that are passed on a period later."""
        later, self._later = self._later, []
        assert len(later) <= 2  # one for stops
        for do in later:
            do()
        return self._taken()

    def _pass(self, request: PageRequest) -> None:
        self.passed.append(
            f"{request['beat']:g}" if request["type"] == "seek" else str(request.get("direct", request["type"]))
        )

    def _taken(self) -> str:
        passed, self.passed = self.passed, []
        return " ".join(passed)


REQUESTS: dict[str, PageRequest] = {
    "stop": {"type": "stop"},
    **{mark: {"type": "stop", "direct": mark} for mark in ("ada 1", "ada 2", "ada 3", "bo 1")},
    "pause": {"type": "pause"},
    "resume": {"type": "resume"},
    "restart": {"type": "restart"},
    "speed": {"type": "speed", "factor": 2.0},
}


def test_a_single_request_is_passed_on_at_once() -> None:
    turned = Turned()
    for request in ("stop", "pause", "resume", "restart", "speed"):
        assert turned.ask(request) == request
        assert turned.turn() == ""


def test_the_latest_of_each_kind_is_passed_on() -> None:
    turned = Turned()
    assert turned.ask(*range(3000), "speed", 5, "pause", 6) == "0"
    assert turned.turn() == "speed pause 6"
    assert turned.ask(7) == ""  # also the period after those
    assert turned.turn() == "7"
    assert turned.turn() == ""
    assert turned.ask(8) == "8"


def test_a_stop_in_a_flood_is_passed_on_at_once_without_earlier_requests() -> None:
    turned = Turned()
    assert turned.ask(0, 1, "restart", "speed", "resume", "stop", "stop", 2, 3) == "0 stop"
    assert sorted(turned.turn().split()) == ["3", "speed", "stop"]


def test_the_latest_stop_of_each_page_is_passed_on() -> None:
    turned = Turned()
    assert turned.ask("ada 1", "ada 2", "bo 1", "ada 3") == "ada 1"
    assert turned.turn() == "bo 1 ada 3"


def test_a_request_that_waits_keeps_the_time_at_which_it_came() -> None:
    passed, later = list[PageRequest](), list[Callable[[], None]]()
    throttle = Throttle(passed.append, lambda delay, do: later.append(do))
    for _ in range(2):
        throttle.take({"type": "restart"})
    came = time.monotonic()
    assert len(passed) == 1
    for do in later:
        do()
    assert [each.get("at", came + 1) <= came for each in passed] == [True, True]


def test_a_page_that_sends_more_than_ours_ever_do_counts_as_flooding() -> None:
    flood = Flood()
    assert not any(flood.counts(7.0 + number / MAX_MESSAGES) for number in range(10 * MAX_MESSAGES))
    assert [flood.counts(20.0) for _ in range(MAX_MESSAGES + 1)] == [*[False] * MAX_MESSAGES, True]
    assert not flood.counts(21.0)
