"""Messages that wait for one page, so that a slow page sees the present and delays no other page."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Awaitable, Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from typing import Literal

from improv_core.protocol.drawn import Bump, Lengthening
from improv_core.protocol.page_messages import AskWindow, BumpJson, Bumps, DrawnMeasured, DrawnTrail, DrawnTrails

MAX_BUMPS = 200
TrailKind = Literal["trails", "measured"]
SendText = Callable[[str], Awaitable[object]]
"""Sends a page a text, over any connection."""


class PageOutbox:
    """The latest message of each kind, all bumps and trails, and the latest question of the page.

    `number` is the number of the page.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        self._waiting: dict[str, str | Callable[[], str]] = {}
        self._bumps: deque[Bump] = deque(maxlen=MAX_BUMPS)
        self._sent: dict[tuple[TrailKind, str], tuple[Lengthening, int]] = {}  # the number of places sent of each trail
        self._filled = asyncio.Event()
        self._empty = asyncio.Event()
        self._question: AskWindow | None = None
        self._asked = asyncio.Event()

    def put(self, kind: str, text: str | Callable[[], str]) -> None:
        """Queue a message behind all others, or a function that writes it when it is sent. It replaces a waiting
        message of its kind."""
        self._waiting.pop(kind, None)
        self._waiting[kind] = text
        self._empty.clear()
        self._filled.set()

    def add_bumps(self, bumps: Iterable[Bump]) -> None:
        """Send bumps, together with those that still wait."""
        self._bumps.extend(bumps)
        self.put("bumps", self._take_bumps)

    def lengthen(self, kind: TrailKind, trails: Mapping[str, Lengthening], placed: int = 0) -> None:
        """Send the parts of robots' trails that the page lacks; `placed` is that of the snapshot."""
        self.put(kind, partial(self._lacking, kind, trails, placed))

    def ask(self, question: AskWindow) -> None:
        """Ask for a window; this replaces a question that nobody has read yet."""
        self._question = question
        self._asked.set()

    async def asked(self) -> AskWindow:
        """Wait for a question."""
        while not self._question:
            await self._asked.wait()
            self._asked.clear()
        question, self._question = self._question, None
        return question

    async def emptied(self) -> None:
        """Wait until the page has received everything."""
        await self._empty.wait()

    async def empty_into(self, send: SendText) -> None:
        """Send everything that waits or will wait, forever."""
        while True:
            await self._filled.wait()
            self._filled.clear()
            while self._waiting:
                kind = next(iter(self._waiting))
                text = self._waiting.pop(kind)
                with suppress(ConnectionError):  # the page is gone: the reading side ends the session
                    await send(text if isinstance(text, str) else text())
            self._empty.set()

    def _lacking(self, kind: TrailKind, trails: Mapping[str, Lengthening], placed: int) -> str:
        robots: dict[str, DrawnTrail] = {}
        for name, trail in trails.items():
            known, sent = self._sent.get((kind, name), (trail, 0))
            begin = sent if known is trail else 0
            places = trail.places[begin:]
            self._sent[kind, name] = trail, begin + len(places)
            if places:
                robots[name] = {"from": begin, "places": [[round(value, 4) for value in place] for place in places]}
        message: DrawnTrails | DrawnMeasured = (
            {"type": "trails", "placed": placed, "robots": robots}
            if kind == "trails"
            else {"type": "measured", "robots": robots}
        )
        return json.dumps(message, separators=(",", ":"))

    def _take_bumps(self) -> str:
        bumps = list(self._bumps)
        self._bumps.clear()
        return bumps_message(bumps, past=False)


class Audience:
    """An outbox for each open page, and the latest message of each kind. All of it runs on the server's thread."""

    def __init__(self) -> None:
        self._outboxes: set[PageOutbox] = set()
        self._joined = 0  # pages so far
        self._latest: dict[str, str] = {}

    def __len__(self) -> int:
        return len(self._outboxes)

    def join(self) -> PageOutbox:
        """Return a new page's outbox, filled with the messages that the other pages have."""
        self._joined += 1
        outbox = PageOutbox(self._joined)
        for kind, text in self._latest.items():
            outbox.put(kind, text)
        self._outboxes.add(outbox)
        return outbox

    def leave(self, outbox: PageOutbox) -> None:
        """Forget a page that was closed."""
        self._outboxes.remove(outbox)

    def put(self, kind: str, text: str) -> None:
        """Send a message to every page, and to later ones until another of its kind replaces it."""
        self._latest[kind] = text
        for outbox in self._outboxes:
            outbox.put(kind, text)


def bumps_message(bumps: Iterable[Bump], past: bool) -> str:
    """Build the `bumps` message; `past` is for bumps from before the page was opened."""
    rows: list[BumpJson] = [
        {"at": round(at, 4), "x": round(x, 4), "y": round(y, 4), "robots": robots, "thing": thing}
        for at, x, y, robots, thing in bumps
    ]
    message: Bumps = {"type": "bumps", "past": past, "bumps": rows}
    return json.dumps(message)
