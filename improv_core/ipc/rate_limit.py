"""Limits how often pages may send requests, so that a flood of them delays nobody."""

from __future__ import annotations

import time
from collections.abc import Callable

from improv_core.protocol.commands import COMMANDS, PageRequest, about

PERIOD = 0.02
"""Seconds from one batch of requests to the next: too few to notice."""
MAX_MESSAGES = 500
"""The most messages that a page may send in a second. A hand on a mouse and ten keys of senses send at most 350."""

PassOn = Callable[[PageRequest], None]
Later = Callable[[float, Callable[[], None]], object]
"""Calls a function after a number of seconds."""


class Throttle:
    """Passes a request on at once, or within `PERIOD` if another was passed on just before.

    A stop waits only for other stops. Of each kind, only the latest waits: it replaces the earlier ones of all pages,
    because all of them control the same performance. So a stop may wait for a moment, but never gets lost. Each request
    gets the time at which it came, since a stop may go another way, and overtake it.
    """

    def __init__(self, pass_on: PassOn, later: Later) -> None:
        self._usual, self._urgent = _Lane(pass_on, later), _Lane(pass_on, later)

    def take(self, request: PageRequest) -> None:
        row, request = COMMANDS[request["type"]], request.copy()
        request.setdefault("at", time.monotonic())
        for void in row.voids:
            self._usual.drop((void, ""))
        (self._urgent if row.overtakes else self._usual).take(about(request), request)


class _Lane:
    """Requests that wait for each other."""

    def __init__(self, pass_on: PassOn, later: Later) -> None:
        self._pass_on = pass_on
        self._later = later
        self._waiting: dict[tuple[str, str], PageRequest] = {}
        self._resting = False

    def take(self, about: tuple[str, str], request: PageRequest) -> None:
        self.drop(about)
        self._waiting[about] = request
        if not self._resting:
            self._pass_waiting()

    def drop(self, about: tuple[str, str]) -> None:
        self._waiting.pop(about, None)

    def _pass_waiting(self) -> None:
        waiting, self._waiting = self._waiting, {}
        self._resting = bool(waiting)
        if waiting:
            self._later(PERIOD, self._pass_waiting)
        for request in waiting.values():
            self._pass_on(request)


class Flood:
    """Notices that a page sends more than `MAX_MESSAGES` messages within a second: none of ours does."""

    def __init__(self) -> None:
        self._since = 0.0
        self._count = 0

    def counts(self, now: float) -> bool:
        """Count a message that comes at a time in seconds. Returns whether the page floods."""
        if now - self._since >= 1.0:
            self._since, self._count = now, 0
        self._count += 1
        return self._count > MAX_MESSAGES
