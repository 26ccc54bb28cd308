"""One open page: the requests that it sends, and the messages and answers that it gets, over any connection."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

from improv_core.page.answers import Answers
from improv_core.page.outbox import PageOutbox, SendText
from improv_core.page.stop_confirmations import Order, PageStops
from improv_core.protocol.commands import COMMANDS, Editing, PageRequest
from improv_core.protocol.page_messages import read


class PageConnection:
    """Passes the requests of the page with this `name` on: `stop` gets the numbers of its new stops, and `pass_on` all
    others for the session. Questions about the score go to `answers`, and what the page is sent waits in the `outbox`.
    """

    def __init__(
        self,
        name: str,
        outbox: PageOutbox,
        answers: Answers,
        stops: PageStops,
        stop: Callable[[int], None],
        pass_on: Callable[[PageRequest], None],
    ) -> None:
        self._outbox = outbox
        self._answers = answers
        self._order = Order(stops, name)
        self._stop = stop
        self._pass_on = pass_on

    def receive(self, text: str) -> None:
        """Take a request. An invalid request is dropped, and so is one that a stop has overtaken and voids."""
        request = read(text)
        if request is None or (self._order.lags and request["type"] in COMMANDS["stop"].voids):
            return
        match request["type"]:
            case "press":
                if self._order.stop(request["number"]):
                    self._stop(request["number"])
            case "window":
                self._outbox.ask(request)
            case "analyze" | "complete" | "explain" | "handle" | "preview" | "write" | "change":
                editing: Editing = {"type": "editing", "page": self._outbox.number, "ask": request}
                if self._order.lags:
                    editing["at"] = 0.0
                self._pass_on(editing)
            case _:
                self._pass_on(request)

    async def send_by(self, send: SendText) -> None:
        """Send everything that waits or will wait, and answer the latest question, forever."""
        await asyncio.gather(self._outbox.empty_into(send), self._answer())

    async def _answer(self) -> None:
        while True:
            question = await self._outbox.asked()
            text = await self._answers.compute(partial(self._answers.window, question))
            if text is not None:
                self._outbox.put("window", text)
