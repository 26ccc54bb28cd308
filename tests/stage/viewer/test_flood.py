"""A page that floods its stage with requests: everybody is still heard, judged by the order of messages."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import aiohttp

from tests.stage.test_process import LIMIT, Process

TOKEN = "a token"
FEW = 200
"""Seeks that a stage may answer before something urgent. A flood sends thousands in the same time."""


class Flooded:
    """A stage that plays, with a page that asks for one beat after another, and a parent that passes requests on."""

    def __init__(self, process: Process) -> None:
        self._process = process
        self._hushes = threading.Event()
        self._over = threading.Event()
        self._sent = 0

    def hush(self) -> None:
        """Have the page stop everything, in the midst of its flood."""
        self._hushes.set()

    def write(self, message: dict[str, Any]) -> None:
        self._process.write(json.dumps(message).encode() + b"\n")

    def until(self, **wanted: object) -> int:
        """Wait for a message with these values; how many seeks were answered before it."""
        answered = 0
        assert self._process.process.stdout
        for line in self._process.process.stdout:
            message = json.loads(line)
            if message.items() >= wanted.items():
                return answered
            if message["type"] == "request" and message["command"]["type"] != "watched":
                self.write(message["command"])
            answered += message["type"] == "transport"
        raise AssertionError(f"the stage ended before {wanted}")

    @contextmanager
    def flood(self) -> Iterator[None]:
        thread = threading.Thread(target=lambda: asyncio.run(self._flood()))
        thread.start()
        try:
            yield
        finally:
            self._over.set()
            thread.join(LIMIT)
        assert self._sent > 10 * FEW

    async def _flood(self) -> None:
        address = self._process.page
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{address}live?token={TOKEN}", origin=address.rstrip("/")) as page,
        ):
            while not self._over.is_set() or self._sent <= 10 * FEW:
                await page.send_json({"type": "seek", "beat": self._sent % 7})
                self._sent += 1
                if self._hushes.is_set():
                    self._hushes.clear()
                    await page.send_json({"type": "hush"})


def test_pings_are_answered_and_a_stop_is_obeyed_while_a_page_floods_its_stage() -> None:
    process = Process({"IMPROV_PAGE_TOKEN": TOKEN})
    process.play("r $ repeat forward\n")
    flooded = Flooded(process)
    try:
        with flooded.flood():
            for number in range(1, 21):
                flooded.until(type="transport", state="playing")  # the answer to a seek
                flooded.write({"type": "ping", "number": number})
                assert flooded.until(type="pong", number=number) < FEW
            flooded.hush()
            assert flooded.until(type="request", command={"type": "hush"}) < FEW
            flooded.write({"type": "hush"})
            assert flooded.until(type="transport", state="stopped") < FEW
    finally:
        process.process.kill()
        process.process.wait(LIMIT)
