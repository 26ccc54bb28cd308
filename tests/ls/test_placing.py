"""Starts that people change on the page become one edit of the program, which the server asks the editor to make."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.ls.client import Client
from tests.ls.test_actions import applied
from tests.open_page import connected, live_behind

CAPABILITIES = {
    "workspace": {"applyEdit": True, "workspaceEdit": {"documentChanges": True}},
    "window": {"showDocument": {"support": True}},
}
PROGRAM = "# 🐢\nanna bert cleo at line 1\nanna bert cleo $ forward\n"
MOVE = {"type": "place", "start_poses": {"cleo": {"x": 1.5, "y": -2, "heading": 90}}}


def ask(live: str, change: Mapping[str, Any]) -> None:
    """Change the program on a page."""

    async def send() -> None:
        async with connected(live) as page:
            await page.send_json({"type": "change", "number": 0, "change": change})

    asyncio.run(send())


def play(client: Client, file: Path, text: str = PROGRAM) -> str:
    """Play a program, and return the address of its page's WebSocket."""
    file.write_text(text, encoding="utf-8")
    client.open(file.as_uri(), text)
    client.save(file.as_uri())
    return live_behind(client.wait_for_page()[0])


def edited(text: str, client: Client) -> tuple[Mapping[str, Any], str]:
    """Return the document of the requested edit, and its text after that."""
    (change,) = client.wait("workspace/applyEdit")["edit"]["documentChanges"]
    return change["textDocument"], applied(text, change["edits"])


@pytest.mark.parametrize(
    ("asked", "opening"),
    [
        (MOVE, "anna bert at line 1 around 0 0.5\ncleo at 1.5 -2 facing 90"),
        ({"type": "arrange", "shape": "grid", "distance": 2, "facing": "in"}, "anna bert cleo at grid 2"),
        ({"type": "tune", "key": "beat", "value": 96}, "beat 96\nanna bert cleo at line 1"),
    ],
)
def test_the_editor_is_asked_to_write_it(tmp_path: Path, asked: Mapping[str, Any], opening: str) -> None:
    file = tmp_path / "dance.improv"
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        ask(play(client, file), asked)
        document, text = edited(PROGRAM, client)
    assert document["uri"] == file.as_uri()
    assert text == f"# 🐢\n{opening}\nanna bert cleo $ forward\n"
    assert file.read_text(encoding="utf-8") == PROGRAM  # never behind the editor's back
    assert not (tmp_path / "improv.toml").exists()


def test_the_text_that_the_editor_has_is_the_one_edited(tmp_path: Path) -> None:
    file = tmp_path / "dance.improv"
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        page = play(client, file)
        text = "# not saved\n\ncleo at 0 0\nanna bert cleo $ left\n"
        client.change(file.as_uri(), 7, {"text": text})
        ask(page, MOVE)
        document, after = edited(text, client)
    assert document == {"uri": file.as_uri(), "version": 7}
    assert after == text.replace("cleo at 0 0", "cleo at 1.5 -2 facing 90")


@pytest.mark.parametrize(
    ("text", "capabilities", "line"),
    [
        ("cleo at 1 x\ncleo $ left\n", CAPABILITIES, "dance.improv was not changed: a line with `at` has an error"),
        ("cleo $ left\n", {"window": CAPABILITIES["window"]}, "write `cleo at 1.5 -2 facing 90` into dance.improv"),
    ],
)
def test_an_unwritten_edit_is_reported(tmp_path: Path, text: str, capabilities: Mapping[str, Any], line: str) -> None:
    file = tmp_path / "dance.improv"
    with Client({"backend": "sim"}, capabilities=dict(capabilities)) as client:
        page = play(client, file, "cleo $ left\n")
        client.change(file.as_uri(), 7, {"text": text})
        ask(page, MOVE)
        client.wait_for_line(line)


def test_an_edit_that_was_not_made_can_be_requested_again(tmp_path: Path) -> None:
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        client.replies["workspace/applyEdit"] = {"result": {"applied": False}}
        page = play(client, tmp_path / "dance.improv")
        for _ in range(2):
            ask(page, MOVE)
            edited(PROGRAM, client)
            client.wait_for_line("the editor did not accept the new start of cleo")


def test_a_song_that_was_moved_is_written_into_its_file(tmp_path: Path) -> None:
    toml = '[music]\nfile = "song.mp3"\n'
    (tmp_path / "improv.toml").write_text(toml, encoding="utf-8")
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        ask(play(client, tmp_path / "dance.improv"), {"type": "tune", "key": "first_beat", "value": 0.35})
        document, text = edited(toml, client)
    assert document["uri"] == (tmp_path / "improv.toml").as_uri()
    assert text == f"{toml}first_beat = 0.35\n"
    assert (tmp_path / "improv.toml").read_text(encoding="utf-8") == toml


def test_a_song_that_no_file_names_is_not_written(tmp_path: Path) -> None:
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        ask(play(client, tmp_path / "dance.improv"), {"type": "tune", "key": "first_beat", "value": 0.35})
        client.wait_for_line("improv.toml was not changed: its section [music] is missing, or written in an unusual")
