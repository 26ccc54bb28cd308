"""The stops of each page, which arrive over two connections, and the requests that a page sent before a stop.

A page numbers its stops. It sends each over a separate connection, with nothing in front of it, and also among its
other requests, where it shows which of these came before it.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

MAX_PAGES = 256
"""Pages that are remembered: more than can be open."""


@dataclass
class _Page:
    arrived: int = 0  # the number of its latest stop
    confirmed: int = 0  # the latest that has been obeyed
    waits_for: str = ""  # the names of the stages that have yet to obey the latest


class PageStops:
    """The state of all pages, each of which has a name."""

    def __init__(self) -> None:
        self._pages: OrderedDict[str, _Page] = OrderedDict()
        self._obeyed = asyncio.Event()  # set, and replaced, whenever a stop was confirmed

    def obeyed(self, direct: str, waits_for: Sequence[str] = ()) -> None:
        """Note that the stop with this identity (its page and its number) has been obeyed, and with it everything that
        the page sent earlier, or by whom it has yet to be. Others than pages have sent those without a number."""
        page, _, number = direct.rpartition(" ")
        if not page:
            return
        known = self._known(page)
        if not waits_for:
            known.confirmed = max(int(number), known.confirmed)
            self._obeyed.set()
            self._obeyed = asyncio.Event()
        elif int(number) == known.arrived:
            known.waits_for = ", ".join(waits_for)

    async def confirmed(self, page: str, number: int, limit: float) -> bool:
        """Return whether a stop is confirmed within `limit` seconds."""
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._until_confirmed(page, number), limit)
        return self.is_confirmed(page, number)

    def arrive(self, page: str, number: int) -> bool:
        """Note that a page has sent this stop. Return whether it is new, so that it has to be obeyed."""
        known = self._known(page)
        is_new = number > known.arrived
        if is_new:
            known.arrived, known.waits_for = number, ""
        return is_new

    def waits_for(self, page: str) -> str:
        """Return the names of those that have yet to obey the latest stop from a page, as far as known."""
        return self._known(page).waits_for

    def is_confirmed(self, page: str, number: int) -> bool:
        return number <= self._known(page).confirmed

    def latest(self, page: str) -> int:
        """Return the number of the latest stop that has arrived from a page."""
        return self._known(page).arrived

    async def _until_confirmed(self, page: str, number: int) -> None:
        while not self.is_confirmed(page, number):
            await self._obeyed.wait()

    def _known(self, page: str) -> _Page:
        known = self._pages.setdefault(page, _Page())
        self._pages.move_to_end(page)
        if len(self._pages) > MAX_PAGES:
            self._pages.popitem(last=False)
        return known


class Order:
    """The order of the requests that come over one connection of a page, and its stops."""

    def __init__(self, stops: PageStops, page: str) -> None:
        self._stops = stops
        self._page = page
        self._placed = stops.latest(page)  # the latest stop with a place in this order

    def stop(self, number: int) -> bool:
        """Take a stop. Return whether it is new; everything after it was requested later."""
        self._placed = max(number, self._placed)
        return self._stops.arrive(self._page, number)

    @property
    def lags(self) -> bool:
        """True while requests that arrive here were sent before a stop that has already arrived."""
        return self._placed < self._stops.latest(self._page)
