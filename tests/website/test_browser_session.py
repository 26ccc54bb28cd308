"""All of Improv on one thread, as the browser's worker runs it: here by Python itself."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

import pytest

from improv_core.website import browser_session
from improv_core.website.browser_session import BrowserBackend

LIMIT = 60.0
Message = dict[str, Any]


class At:
    """A page that is at home."""

    def __init__(self) -> None:
        self.messages: list[Message] = []
        self.obeyed: list[int] = []
        self._new = asyncio.Event()
        self.home = BrowserBackend(self._take, self.obeyed.append)

    def ask(self, kind: str, **values: Any) -> None:
        self.home.hear(json.dumps({"type": kind, **values}))

    def save(self, text: str, number: int = 1) -> None:
        self.ask("write", number=number, text=text, revision="0")

    async def wait(self, kind: str, fits: Callable[[Message], bool] = lambda message: True) -> Message:
        """Wait for the first message of this type that fits, which may have come before."""

        async def find() -> Message:
            while True:
                for message in self.messages:
                    if message["type"] == kind and fits(message):
                        return message
                self._new.clear()
                await self._new.wait()

        return await asyncio.wait_for(find(), LIMIT)

    def _take(self, text: str) -> None:
        self.messages.append(json.loads(text))
        self._new.set()


@asynccontextmanager
async def at_home(text: str = "", toml: str = "", beat: float = 0.0) -> AsyncIterator[At]:
    """Yield a page that is at home."""
    at, ready = At(), asyncio.Event()
    serving = asyncio.create_task(at.home.serve(text, toml, 7, beat, ready.set))
    await asyncio.wait_for(ready.wait(), LIMIT)
    yield at
    serving.cancel()
    with suppress(asyncio.CancelledError):
        await serving


async def test_a_page_gets_its_program_and_nothing_plays_by_itself() -> None:
    async with at_home("ada $ forward") as at:
        source = await at.wait("source")
        assert (source["text"], source["revision"]) == ("ada $ forward", "7")
        at.ask("analyze", number=1, text="ada $ forwrd")
        assert (await at.wait("analyze"))["count"] == 1
        assert not [each for each in at.messages if each["type"] in ("score", "transport")]


async def test_meetings_are_reported_once_nobody_types(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(browser_session, "LONGEST_CHECK", LIMIT)  # the machine may do other things

    async with at_home() as at:
        at.ask("analyze", number=1, text="ada at 0 0\nbo at 1 0 facing 180\nada bo $ forward")
        found = await at.wait("check")
        assert "`ada` and `bo` meet at beat" in found["problems"][0]["message"]


async def test_paths_that_a_busy_browser_could_not_draw_at_once_follow_once_nobody_types(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(browser_session, "LONGEST_PREVIEW", -1.0)
    monkeypatch.setattr(browser_session, "LONGEST_CHECK", LIMIT)

    async with at_home() as at:
        at.ask("analyze", number=1, text="ada $ repeat 4 (forward left)")
        at.ask("preview", number=1)
        assert (await at.wait("preview"))["robots"].keys() == {"ada"}


async def test_a_saved_program_plays_to_its_end() -> None:
    async with at_home() as at:
        at.save("beat 1200\nada $ forward left")
        assert (await at.wait("write"))["revision"] == "8"
        assert (await at.wait("score"))["robots"].keys() == {"ada"}
        await at.wait("transport", lambda each: each["state"] == "ended")
        poses = await at.wait("poses", lambda each: bool(each["poses"]) and each["poses"][0][0] > 1.99)
        assert poses["poses"][0][:2] == [2, 0]


async def test_a_stop_is_obeyed_and_confirmed() -> None:
    async with at_home() as at:
        at.save("ada $ repeat forward")
        await at.wait("transport", lambda each: each["state"] == "playing")
        at.ask("press", number=3)
        await at.wait("transport", lambda each: each["state"] == "stopped")
        assert at.obeyed == [3]


async def test_a_program_with_errors_has_messages_and_the_dance_continues() -> None:
    async with at_home() as at:
        at.save("ada $ repeat forward")
        await at.wait("transport", lambda each: each["state"] == "playing")
        at.save("ada $ forwrd", 2)
        (problem,) = (await at.wait("program", lambda each: each["count"] == 1))["problems"]
        assert (problem["line"], problem["word"]) == (1, "forwrd")
        assert [each["state"] for each in at.messages if each["type"] == "transport"] == ["playing"]


async def test_words_lit_and_completed_come_from_here_too() -> None:
    async with at_home() as at:
        at.ask("analyze", number=1, text="ada $ forw")
        at.ask("complete", number=1, offset=10)
        assert [each["word"] for each in (await at.wait("complete"))["words"]] == ["forward"]
        at.save("ada $ forward left", 2)
        generation = (await at.wait("score"))["generation"]
        at.ask("window", generation=generation, **{"from": 0, "to": 2})
        assert (await at.wait("window"))["robots"].keys() == {"ada"}
        assert (at.home.paths() or "").startswith("<svg")


async def test_robots_are_those_of_its_improv_toml() -> None:
    async with at_home(toml='[robots.ada]\nprofile = "quadrotor"\nstart = {}\n') as at:
        at.save("beat 1200\nada $ forward")
        await at.wait("poses", lambda each: bool(each["poses"]) and each["poses"][0][0] == 0.5)


async def test_an_error_in_improv_toml_has_its_line_and_can_be_fixed() -> None:
    async with at_home(toml='[robots.ada]\nprofile = "nothing"\n') as at:
        at.ask("analyze", number=1, text="ada $ forward")
        found = await at.wait("analyze", lambda each: each["number"] == 1)
        assert [(each["file"], each["line"]) for each in found["problems"]] == [("improv.toml", 2)]
        at.save("ada $ forward")
        (problem,) = (await at.wait("program", lambda each: each["count"] == 1))["problems"]
        assert (problem["file"], problem["line"]) == ("improv.toml", 2)
        at.home.use('[robots.ada]\nprofile = "quadrotor"\n')
        at.ask("analyze", number=2, text="ada $ forward")
        assert (await at.wait("analyze", lambda each: each["number"] == 2))["count"] == 0
        at.save("ada $ forward", 2)
        await at.wait("transport", lambda each: each["state"] == "playing")


async def test_a_program_from_a_link_begins_at_its_beat_once() -> None:
    async with at_home("ada $ repeat 8 left", beat=5.5) as at:
        at.save("ada $ repeat 8 left")
        began = await at.wait("transport", lambda each: each["state"] == "playing" and each["beat"] >= 5)
        at.save("ada $ repeat 8 left", 2)
        await at.wait("transport", lambda each: each["generation"] > began["generation"] and each["beat"] < 1)


async def test_another_program_than_that_of_the_link_begins_at_its_beginning() -> None:
    async with at_home("ada $ repeat 8 left", beat=5.5) as at:
        at.save("ada $ repeat 8 right")
        began = await at.wait("transport", lambda each: each["state"] == "playing")
        assert began["beat"] < 1


def test_a_qr_code_holds_a_link() -> None:
    code = BrowserBackend(lambda text: None, lambda number: None).code("https://example.org/#dance=abc")
    assert code.startswith("<svg xmlns=")
