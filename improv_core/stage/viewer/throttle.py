"""Bounds how often pages may ask for something, so that a flood of requests delays nobody."""

from __future__ import annotations

from collections.abc import Callable

from improv_core.stage.protocol import PageRequest
from improv_core.stage.urgent_queue import URGENT

PERIOD = 0.02
"""Seconds from one batch of requests to the next: fewer than anybody notices."""


class Throttle:
    """Passes a request on at once, or within `PERIOD` if another was passed on just before.

    Of each kind, only the latest waits: it replaces the earlier ones of all pages, because all of them control the same
    performance. So a stop may wait for a moment, but never gets lost.
    `later` calls a function after so many seconds.
    """

    def __init__(
        self,
        pass_on: Callable[[PageRequest], None],
        later: Callable[[float, Callable[[], None]], object],
    ) -> None:
        self._pass_on = pass_on
        self._later = later
        self._waiting: dict[str, PageRequest] = {}
        self._resting = False

    def take(self, request: PageRequest) -> None:
        for void in (_about(request), *URGENT.get(request["type"], ())):
            self._waiting.pop(void, None)
        self._waiting[_about(request)] = request
        if not self._resting:
            self._pass_waiting()

    def _pass_waiting(self) -> None:
        waiting, self._waiting = self._waiting, {}
        self._resting = bool(waiting)
        if waiting:
            self._later(PERIOD, self._pass_waiting)
        for request in waiting.values():
            self._pass_on(request)


def _about(request: PageRequest) -> str:
    """What only the latest request counts of: its kind, and which key, sense, or page it is about."""
    if request["type"] == "key":
        return f"key {request['key']}"
    if request["type"] == "editing":  # each page has a text of its own
        return f"editing {request['page']} {request['ask']['type']}"
    return f"force {request['robot']} {request['sense']}" if request["type"] == "force" else request["type"]
