"""The paths of the text in an editor, on the page, before somebody saves it."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path
from typing import Any

import pytest

from improv_core.ipc.asking import Answerer
from tests.ls.client import LIMIT, Client
from tests.ls.test_placing import CAPABILITIES, play
from tests.open_page import connected, heard

HEAD = "room 10m 4m\nada at 0 0\n"


async def _draft(live: str, text: str) -> Any:
    """Return the paths of this text, once all are known."""
    async with connected(live) as page:
        draft = await heard(
            page, lambda told: told["type"] == "draft" and told["text"] == text and not told["paths"]["waits_for"]
        )
    return {name: path["strokes"][-1][3:5] for name, path in draft["paths"]["robots"].items()}


def draft(live: str, text: str) -> Any:
    """Return the ends of the paths in this text, once all are known."""
    return asyncio.run(asyncio.wait_for(_draft(live, text), LIMIT))


def test_the_page_draws_a_text_before_it_is_saved_until_it_is_closed(tmp_path: Path) -> None:
    file = tmp_path / "dance.improv"
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        live = play(client, file, f"{HEAD}ada $ forward\n")
        client.change(file.as_uri(), 2, {"text": f"{HEAD}ada $ forward 1m\n"})
        assert draft(live, f"{HEAD}ada $ forward 1m\n") == {"ada": [1, 0]}
        client.change(file.as_uri(), 3, {"text": f"{HEAD}ada $ until near repeat forward 1m\n"})
        ((x, _),) = draft(live, f"{HEAD}ada $ until near repeat forward 1m\n").values()
        assert 1 < x < 5  # the simulator has decided: no picture of a robot that never senses ends there
        assert x != 4
        other = tmp_path / "other.improv"
        client.open(other.as_uri(), f"{HEAD}ada $ left\n")
        client.change(other.as_uri(), 2, {"text": f"{HEAD}ada $ right\n"})
        client.notify("textDocument/didClose", {"textDocument": {"uri": file.as_uri()}})
        assert draft(live, "") == {}


def test_the_page_gets_no_paths_of_an_older_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, begun, typed = tmp_path / "dance.improv", threading.Event(), threading.Event()
    texts = [f"{HEAD}ada $ forward {length}m\n" for length in (1, 2, 3)]
    drafts: list[str] = []

    async def listen(live: str) -> None:
        async with connected(live) as page:
            while texts[2] not in drafts:
                drafts.append((await heard(page, lambda told: told["type"] == "draft"))["text"])

    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client, monkeypatch.context() as patch:
        look = Answerer.ask

        def late(answerer: Any, program: Any) -> Any:
            begun.set()
            assert typed.wait(LIMIT)
            return look(answerer, program)

        live = play(client, file, texts[0])
        listening = threading.Thread(target=lambda: asyncio.run(asyncio.wait_for(listen(live), LIMIT)))
        listening.start()
        patch.setattr(Answerer, "ask", late)
        client.change(file.as_uri(), 2, {"text": texts[1]})
        assert begun.wait(LIMIT)
        client.change(file.as_uri(), 3, {"text": texts[2]})
        client.request("textDocument/documentSymbol", {"textDocument": {"uri": file.as_uri()}})
        typed.set()
        listening.join(LIMIT)
    assert drafts[-1] == texts[2]
    assert texts[1] not in drafts
