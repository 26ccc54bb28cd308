"""A page that floods its stage with requests: all others still get answers, as the order of messages shows."""

from __future__ import annotations

import asyncio
import http.client
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from urllib.parse import urlsplit

import aiohttp
import pytest

from improv_core.ipc.arrivals import Arrival, End, UrgentQueue
from improv_core.page.__main__ import open_simulated, options_in
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.decoding import dumps
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.safety.heartbeat import Parent
from improv_core.score.score_json import RowsRead, to_json
from improv_core.stage.loop import run
from improv_core.stage.process import SystemClock
from improv_core.stage.stdio import arrival
from tests.page.conftest import LIMIT

TOKEN = "a-token"
FEW = 3
"""Seeks that a stage may answer before something urgent: those that it had taken already when that came."""
DANCE = to_json(score_of(analyze("r $ repeat forward\n")))


class Stage:
    """A stage on a thread, and a parent that passes requests of pages on to it and answers about their stops, and keeps
    the messages of both, in order."""

    def __init__(self) -> None:
        self._inbox: UrgentQueue[Arrival] = UrgentQueue()
        self._said = threading.Condition()
        self._log: list[FromStage | ToStage] = []
        opened, ready, viewer = open_simulated(options_in(["--simulate", "--port", "0"]), self._hear, TOKEN)
        self.page, self._viewer = ready["page"], viewer
        self._thread = threading.Thread(target=run, args=(opened, self._inbox, SystemClock(), Parent()))
        self._thread.start()

    def write(self, message: ToStage) -> int:
        """Send a message; return its place in the log."""
        with self._said:
            self._log.append(message)
            self._said.notify_all()
            self._inbox.put(arrival(dumps(message), RowsRead()))
            return len(self._log)

    def until(self, since: int = 0, **wanted: object) -> tuple[int, int]:
        """Wait for a message with these values: return its place in the log, and the number of seeks that were answered
        before it."""
        with self._said:
            at = since
            while True:
                while len(self._log) <= at:
                    assert self._said.wait(LIMIT), f"not said: {wanted}"
                if self._log[at].items() >= wanted.items():
                    return at, sum(each["type"] == "transport" for each in self._log[since:at])
                at += 1

    def close(self) -> None:
        self._inbox.put(End())
        self._thread.join(LIMIT)
        self._viewer.close()

    def _hear(self, message: FromStage) -> None:
        with self._said:
            self._log.append(message)
            self._said.notify_all()
        if message["type"] == "request" and message["command"]["type"] in ("seek", "stop"):
            self.write(message["command"])
        elif message["type"] == "obeyed":
            self._viewer.publish(message)


@pytest.fixture
def stage() -> Iterator[Stage]:
    stage = Stage()
    yield stage
    stage.close()


@contextmanager
def flood(page: str) -> Iterator[threading.Semaphore]:
    """Ask for one beat after another, without end. Released each time that the server has cut this off."""
    over, cut = threading.Event(), threading.Semaphore(0)

    async def ask() -> None:
        async with aiohttp.ClientSession() as session:
            while not over.is_set():
                with suppress(ConnectionError, aiohttp.ClientError):
                    async with session.ws_connect(
                        f"{page}live?token={TOKEN}&page=p", origin=page.rstrip("/")
                    ) as socket:
                        beat = 0
                        while not over.is_set():
                            await socket.send_json({"type": "seek", "beat": (beat := (beat + 1) % 7)})
                cut.release()

    thread = threading.Thread(target=lambda: asyncio.run(ask()))
    thread.start()
    try:
        yield cut
    finally:
        over.set()
        thread.join(LIMIT)


def press(page: str) -> int:
    """Send a stop as a page does, again and again until it is confirmed; return the status of the last answer."""
    while True:
        connection = http.client.HTTPConnection(urlsplit(page).netloc, timeout=LIMIT)
        connection.request("POST", f"/stop?token={TOKEN}&page=p&number=1", headers={"Origin": page.rstrip("/")})
        if (status := connection.getresponse().status) != 202:
            return status


def test_pings_are_answered_and_a_stop_is_obeyed_while_a_page_floods_its_stage(stage: Stage) -> None:
    stage.write({"type": "load", "generation": 1, "score": DANCE, "when": "restart", "backend": "simulator"})
    at, _ = stage.until(type="transport", state="playing")
    with flood(stage.page) as cut:
        for number in range(1, 21):
            at, _ = stage.until(at + 1, type="transport", state="playing")  # the answer to a seek
            _, answered = stage.until(stage.write({"type": "ping", "number": number}), type="pong", number=number)
            assert answered <= FEW
        assert cut.acquire(timeout=LIMIT)
        assert press(stage.page) == 204
        at, _ = stage.until(at, type="stop", direct="p 1")
        _, answered = stage.until(at, type="transport", state="stopped")
        assert answered <= FEW
