"""Starts dragged on the page become one edit of improv.toml that the editor is asked to make."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import aiohttp
import pytest
from lsprotocol import types

from improv_core.text import LineIndex
from improv_ls.positions import to_span
from tests.ls.client import Client, Message
from tests.page import live_behind

CAPABILITIES = {
    "workspace": {"applyEdit": True, "workspaceEdit": {"resourceOperations": ["create"]}},
    "window": {"showDocument": {"support": True}},
}
ANNA = {"anna": {"x": 1.5, "y": -2, "heading": 90}}
BERT = {"bert": {"x": 0.125, "y": 0, "heading": 0}}
START = "start = { x = 1.5, y = -2, heading = 90 }\n"
BERTS = "start = { x = 0.125, y = 0, heading = 0 }\n"


def drag(live: str, starts: Mapping[str, Any]) -> None:
    ask(live, {"type": "place", "start_poses": starts})


def ask(live: str, message: Mapping[str, Any]) -> None:
    """Send what a page sends."""

    async def send() -> None:
        origin = live[: live.index("/live")]
        async with aiohttp.ClientSession() as session, session.ws_connect(live, headers={"Origin": origin}) as socket:
            await socket.send_json(message)

    asyncio.run(send())


def play(client: Client, folder: Path) -> str:
    """Play a program of two robots; the address of its page's WebSocket."""
    program = folder / "dance.improv"
    client.open(program.as_uri(), "anna $ forward\nbert $ forward\n")
    client.save(program.as_uri())
    return live_behind(client.wait_for_page()[0])


def asked(client: Client) -> list[Any]:
    """The changes of the one edit that the editor is asked to make."""
    changes: list[Any] = client.wait("workspace/applyEdit")["edit"]["documentChanges"]
    return changes


def edited(text: str, change: Any) -> str:
    """A text after a change of it."""
    (edit,) = change["edits"]
    begin, end = (types.Position(**edit["range"][side]) for side in ("start", "end"))
    span = to_span(LineIndex(text), types.Range(begin, end), "utf-16")
    return text[: span.start] + str(edit["newText"]) + text[span.end :]


@pytest.mark.parametrize(
    ("before", "starts", "after"),
    [
        (
            "[robots.anna]\nstart = { x = 3 } # 🐢\n[robots.bert]\n",
            ANNA,
            f"[robots.anna]\n{START[:-1]} # 🐢\n[robots.bert]\n",
        ),
        ("# 🐢\n[robots.anna]\n[robots.bert]\n", ANNA | BERT, f"# 🐢\n[robots.anna]\n{START}[robots.bert]\n{BERTS}"),
        ("", ANNA | BERT, f"[robots.anna]\n{START}\n[robots.bert]\n{BERTS}"),
    ],
)
def test_the_editor_is_asked_to_write_it(tmp_path: Path, before: str, starts: Mapping[str, Any], after: str) -> None:
    robots = tmp_path / "improv.toml"
    robots.write_text(before, encoding="utf-8")
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        drag(play(client, tmp_path), starts)
        (change,) = asked(client)
    assert change["textDocument"] == {"uri": robots.as_uri(), "version": None}
    assert edited(before, change) == after
    assert robots.read_text(encoding="utf-8") == before  # never behind the editor's back


def test_a_missing_file_is_created_once(tmp_path: Path) -> None:
    robots = tmp_path / "improv.toml"
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        page = play(client, tmp_path)
        drag(page, BERT)
        create, change = asked(client)
        assert create == {"kind": "create", "uri": robots.as_uri(), "options": {"ignoreIfExists": True}}
        assert edited("", change) == f"[robots.anna]\n\n[robots.bert]\n{BERTS}"
        drag(page, ANNA)
        client.wait_for_line("save improv.toml first")
        robots.touch()  # as VS Code makes it, before it is saved
        drag(page, ANNA)
        client.wait_for_line("save improv.toml first")
        robots.write_text(edited("", change), encoding="utf-8")
        drag(page, ANNA)
        (change,) = asked(client)
        before = robots.read_text(encoding="utf-8")
        assert edited(before, change) == f"[robots.anna]\n{START}\n[robots.bert]\n{BERTS}"


def test_a_formation_is_offered_like_starts(tmp_path: Path) -> None:
    robots = tmp_path / "improv.toml"
    robots.write_text("[robots.anna]\n[robots.bert]\n", encoding="utf-8")
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        ask(play(client, tmp_path), {"type": "form", "shape": "line", "distance": 2, "facing": "in"})
        (change,) = asked(client)
    after = edited(robots.read_text(encoding="utf-8"), change)
    assert after == '[robots.anna]\n[robots.bert]\n\n[formation]\nshape = "line"\ndistance = 2\n'


def test_unsaved_edits_are_not_written_twice(tmp_path: Path) -> None:
    robots = tmp_path / "improv.toml"
    before = "[robots.anna]\n[robots.bert]\n"
    robots.write_text(before, encoding="utf-8")
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        page = play(client, tmp_path)
        drag(page, ANNA)
        unsaved = edited(before, asked(client)[0])
        drag(page, BERT)
        client.wait_for_line("save improv.toml first")
        robots.write_text(unsaved, encoding="utf-8")
        drag(page, BERT)
        assert edited(unsaved, asked(client)[0]) == f"[robots.anna]\n{START}[robots.bert]\n{BERTS}"


def test_the_text_of_an_editor_that_tells_it_is_the_one_edited(tmp_path: Path) -> None:
    robots = tmp_path / "improv.toml"
    robots.write_text("[robots.anna]\n[robots.bert]\n", encoding="utf-8")
    text = "# not saved\n[robots.bert]\n[robots.anna]\n"
    document = {"uri": robots.as_uri(), "languageId": "toml", "version": 7, "text": text}
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        page = play(client, tmp_path)
        client.notify("textDocument/didOpen", {"textDocument": document})
        drag(page, BERT)
        (change,) = asked(client)
        assert change["textDocument"] == {"uri": robots.as_uri(), "version": 7}
        text = edited(text, change)
        assert text == f"# not saved\n[robots.bert]\n{BERTS}[robots.anna]\n"
        client.change(robots.as_uri(), 8, {"text": text})
        drag(page, ANNA | {"bert": {"x": 3, "y": 0, "heading": 0}})
        (change,) = asked(client)
        after = f"# not saved\n[robots.bert]\nstart = {{ x = 3, y = 0, heading = 0 }}\n[robots.anna]\n{START}"
        assert edited(text, change) == after


def test_unusual_ways_to_write_starts_are_left_to_their_author(tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text('[robots]\nanna.profile = "turtlesim"\nbert = {}\n', encoding="utf-8")
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        drag(play(client, tmp_path), ANNA)
        line = client.wait_for_line("improv.toml was not changed")
    assert line.endswith("add robots.anna.start = { x = 1.5, y = -2, heading = 90 } yourself")


class Refusing(Client):
    """An editor that makes no edit."""

    def _answer(self, request: Message) -> None:
        if request["method"] == "workspace/applyEdit":
            self._write({"id": request["id"], "result": {"applied": False}})
        else:
            super()._answer(request)


def test_an_edit_that_was_not_made_can_be_requested_again(tmp_path: Path) -> None:
    with Refusing({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        page = play(client, tmp_path)
        for _ in range(2):
            drag(page, ANNA)
            assert len(asked(client)) == 2
            client.wait_for_line("the editor did not accept the new start of anna")
