"""Stops in an editor: no older save overtakes them, and no analysis delays them."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.ls.client import LIMIT, QUIET, TOLD, Client, Message, ProcessClient
from tests.open_page import connected, heard, live_behind

URI, HUGE = "file:///dance.improv", "file:///huge.improv"
HUGE_PROGRAM = "".join(f"r $ repeat {count} (forward left)\n" for count in range(2, 15_000)) + "r $ forwrd\n"
"""It takes seconds to analyze, a hundred times as long as a stop, and only then is the error in its last line known."""
STOP, HUSH, PAUSE = (
    {"method": "workspace/executeCommand", "params": {"command": f"improv.{name}", "arguments": []}}
    for name in ("stop", "hush", "pause")
)
PUBLISHED = "textDocument/publishDiagnostics"
SAVE = {"method": "textDocument/didSave", "params": {"textDocument": {"uri": URI}}}


class Dancer(Client):
    """An editor whose program plays."""

    _version = 1

    def __init__(self) -> None:
        super().__init__(QUIET, TOLD)
        self.open(URI, "r $ repeat forward\n")
        self.save(URI)
        self.wait_for_state("playing")

    def wait_for_state(self, state: str) -> None:
        self.wait("improv/transport", lambda transport: transport["state"] == state)

    def page(self) -> str:
        """A URL that opens the page."""
        return str(self.command("page"))

    def write(self, *messages: Message) -> int:
        """Write messages at once, of which the last one is a request. Return its ID."""
        self._next_id += 1
        self._write(*messages[:-1], {"id": self._next_id, **messages[-1]})
        return self._next_id

    def retype(self, text: str) -> Message:
        self._version += 1
        document = {"uri": URI, "version": self._version}
        return {
            "method": "textDocument/didChange",
            "params": {"textDocument": document, "contentChanges": [{"text": text}]},
        }

    def has_analyzed_huge(self, until: float = math.inf) -> bool:
        """Return whether the server had published the error of the huge program by a time.

        `time.perf_counter` and `time.monotonic` read the same clock on Linux.
        """
        published = [each for each in list(self.log) if each.message.get("method") == PUBLISHED]
        return any(each.at <= until and is_error_of_huge(each.message["params"]) for each in published)

    def played_since(self, number: int) -> list[Any]:
        """Return the scores that have begun to play since the answer to a request."""
        messages = [spoken.message for spoken in list(self.log) if spoken.by_server]
        since = next(place for place, each in enumerate(messages) if each.get("id") == number and "method" not in each)
        return [each for each in messages[since:] if "▶" in str(each.get("params"))]


def is_error_of_huge(published: Any) -> bool:
    return bool(published["uri"] == HUGE and published["diagnostics"])


class DancerProcess(Dancer, ProcessClient):
    """An editor whose server is a process: a thread beside the test would not show whether it reads while it
    computes."""


@pytest.fixture
def client() -> Iterator[Dancer]:
    with Dancer() as client:
        yield client


@pytest.mark.parametrize("stop", [STOP, HUSH, PAUSE])
def test_a_stop_in_the_same_read_as_a_save_wins(client: Dancer, stop: Message) -> None:
    client.write(SAVE, stop)
    assert client.wait_for_line("dance.improv") == "■ dance.improv was stopped before it began: save to play it"
    client._write(client.retype("s $ repeat left\n"), SAVE)
    assert client.wait_for_line("▶ s ∞")


@pytest.mark.parametrize("stop", [STOP, HUSH])
def test_a_stop_after_a_storm_of_saves(client: Dancer, stop: Message) -> None:
    again = {"method": "workspace/executeCommand", "params": {"command": "improv.restart", "arguments": []}}
    number = client.write(*[SAVE] * 400, *[{"id": f"again {each}", **again} for each in range(20)], stop)
    client.answer(number)
    client.wait_for_state("stopped")
    client._write(client.retype("s $ repeat left\n"), SAVE)
    assert client.wait_for_line("▶ s")
    assert len(client.played_since(number)) == 1


def test_a_resume_and_a_pause_in_one_read(client: Dancer) -> None:
    client.write(PAUSE)
    client.wait_for_state("paused")
    paused = len(client.log)
    resume = {"id": "resume", "method": "workspace/executeCommand", "params": {"command": "improv.resume"}}
    client.write(resume, PAUSE)
    client.write(STOP)
    client.wait_for_state("stopped")
    told = [spoken.message for spoken in client.log[paused:] if spoken.message.get("method") == "improv/transport"]
    assert [each["params"]["state"] for each in told] == ["stopped"]


def until_stopped(client: Dancer, act: Callable[[], object]) -> tuple[float, float]:
    """Act, and return the time before that, and that at which the robots stopped, as their stage itself reports it."""
    live = live_behind(client.page())

    async def stopped() -> tuple[float, float]:
        async with connected(live) as page:
            began = time.monotonic()
            act()
            told = await heard(page, lambda told: told["type"] == "transport" and told["state"] == "stopped")
            return began, told["monotonic"]

    return asyncio.run(asyncio.wait_for(stopped(), LIMIT))


@pytest.mark.slow("a huge program is analyzed")
def test_a_stop_while_a_huge_program_is_analyzed() -> None:
    with DancerProcess() as client:
        stop_while_analyzing(client)


def stop_while_analyzing(client: Dancer) -> None:
    numbers = list[int]()

    def stop() -> None:
        client.open(HUGE, HUGE_PROGRAM)
        client._write(SAVE)
        numbers.append(client.write(STOP))

    began, stopped = until_stopped(client, stop)
    # A save after the stop plays: the stop counts only once, although its answer comes long after. Not earlier: a slow
    # page gets only the latest message, that `s` plays.
    client._write(client.retype("s $ repeat left\n"), SAVE)
    client.answer(*numbers)
    assert client.wait_for_line("▶ s ∞")
    assert len(client.played_since(*numbers)) == 1
    if not client.has_analyzed_huge():
        client.wait(PUBLISHED, is_error_of_huge)
    assert stopped - began < (time.monotonic() - began) / 2, "its analysis takes a hundred times as long as a stop"


@pytest.mark.slow("a huge program is analyzed")
def test_the_end_of_the_editor_while_a_huge_program_is_analyzed() -> None:
    client = DancerProcess()

    def end() -> None:
        client.open(HUGE, HUGE_PROGRAM)
        assert client.process.stdin
        client.process.stdin.close()

    _, stopped = until_stopped(client, end)
    assert client.process.wait(LIMIT) == 1
    assert not client.has_analyzed_huge(until=stopped)
