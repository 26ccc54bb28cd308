"""Fixes, refactorings and formatting as an editor asks for them, columns in UTF-16."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.ls.client import CAPABILITIES, Client

URI = "file:///dance.improv"
VERSIONED = {**CAPABILITIES, "workspace": {"workspaceEdit": {"documentChanges": True}}}


def applied(text: str, edits: list[dict[str, Any]]) -> str:
    """The text after edits whose columns count UTF-16 units."""
    lines = [line.encode("utf-16-le") for line in text.splitlines(keepends=True)]

    def offset(position: dict[str, int]) -> int:
        return sum(map(len, lines[: position["line"]])) + 2 * position["character"]

    whole = text.encode("utf-16-le")
    for edit in sorted(edits, key=lambda edit: offset(edit["range"]["start"]), reverse=True):
        start, end = offset(edit["range"]["start"]), offset(edit["range"]["end"])
        whole = whole[:start] + edit["newText"].encode("utf-16-le") + whole[end:]
    return whole.decode("utf-16-le")


def actions(client: Client, line: int, column: int, **context: Any) -> dict[str, dict[str, Any]]:
    place = {"line": line, "character": column}
    params = {
        "textDocument": {"uri": URI},
        "range": {"start": place, "end": place},
        "context": {"diagnostics": [], **context},
    }
    return {action["title"]: action for action in client.request("textDocument/codeAction", params)}


def test_a_mistake_is_mended() -> None:
    before = "# 🐢\r\nr $ forward (  # 🐢\r\nforwrd)\r\n"
    with Client({"onSave": "off"}, capabilities=VERSIONED) as client:
        client.open(URI, before)
        found = actions(client, 2, 3, only=["quickfix"])
        (change,) = found["Change to forward"]["edit"]["documentChanges"]
        assert change["textDocument"] == {"uri": URI, "version": 1}
        assert applied(before, change["edits"]) == before.replace("forwrd", "forward")
        assert found["Change to forward"]["diagnostics"][0]["code"] == "unknown-name"


def test_all_that_is_safe_is_fixed_at_once_for_those_who_ask_for_it() -> None:
    before = "# 🐢\r\nr $ 𝑥, up | left\r\n𝑦 = fowrard\r\n"
    with Client({"onSave": "off"}, capabilities=VERSIONED) as client:
        assert "source.fixAll.improv" in client.initialized["capabilities"]["codeActionProvider"]["codeActionKinds"]
        client.open(URI, before)
        assert not any("safe" in title for title in actions(client, 1, 0))
        for only in ("source", "source.fixAll", "source.fixAll.improv"):
            ((title, action),) = actions(client, 0, 0, only=[only]).items()
            assert (title, action["kind"]) == ("Fix all that is safe to fix", "source.fixAll.improv")
            (change,) = action["edit"]["documentChanges"]
            assert applied(before, change["edits"]) == "# 🐢\r\nr $ 𝑥 up || left\r\n𝑦 = fowrard\r\n"
        assert actions(client, 0, 0, only=["source.organizeImports"]) == {}


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with Client({"onSave": "off"}, capabilities=VERSIONED) as client:
        yield client


def check(client: Client, title: str, before: str, after: str) -> None:
    """The one action for what is selected, `<…>`, whose title begins so makes this of the program."""
    start, end = before.index("<"), before.index(">") - 1
    text = before.replace("<", "").replace(">", "")
    client.open(URI, text)
    params = {
        "textDocument": {"uri": URI},
        "range": {"start": place(text, start), "end": place(text, end)},
        "context": {"diagnostics": []},
    }
    found = client.request("textDocument/codeAction", params)
    (action,) = [each for each in found if each["title"].startswith(title)]
    (change,) = action["edit"]["documentChanges"]
    assert applied(text, change["edits"]) == after
    client.notify("textDocument/didClose", {"textDocument": {"uri": URI}})


def place(text: str, offset: int) -> dict[str, int]:
    before = text[:offset]
    line = before[before.rfind("\n") + 1 :]
    return {"line": before.count("\n"), "character": len(line.encode("utf-16-le")) // 2}


@pytest.mark.parametrize(
    ("title", "before", "after"),
    [
        ("Extract", "# 🐢\r\nr $ 𝑥 <up left> up\r\n", "# 🐢\r\nup_left = up left\r\nr $ 𝑥 up_left up\r\n"),
        ("Inline", "𝑥 = up left\r\nr $ reverse <>𝑥 # 🐢\r\n", "r $ reverse (up left) # 🐢\r\n"),
        ("Inline 𝑥 here", "𝑥 = up left\nr $ 𝑥 <>𝑥\n", "𝑥 = up left\nr $ 𝑥 up left\n"),
        ("Inline 𝑥 everywhere", "<>𝑥 = up left\nr $ 𝑥 fast 2 𝑥\n", "r $ up left fast 2 (up left)\n"),
        ("Unroll", "# 🐢\r\nr $ 𝑥 <>repeat 2 (up left)\r\n", "# 🐢\r\nr $ 𝑥 up left up left\r\n"),
        ("Fold into repeat 2", "r $ 𝑥 <up left up left> # 🐢\r\n", "r $ 𝑥 repeat 2 (up left) # 🐢\r\n"),
        ("Wrap in ( )", "r $ 𝑥 <up left> 𝑥\r\n", "r $ 𝑥 (up left) 𝑥\r\n"),
        ("Wrap in [ ]", "r $ 𝑥 <up left> 𝑥\r\n", "r $ 𝑥 [up left] 𝑥\r\n"),
        ("Wrap in slow 2", "r $ 𝑥 <up left> 𝑥\r\n", "r $ 𝑥 slow 2 (up left) 𝑥\r\n"),
    ],
)
def test_a_movement_is_written_differently(client: Client, title: str, before: str, after: str) -> None:
    check(client, title, before, after)


@pytest.mark.parametrize(
    ("title", "before", "after"),
    [
        ("Insert )", "r $ 𝑥 <>(up # 🐢\r\n", "r $ 𝑥 (up) # 🐢\r\n"),
        ("Remove it", "r $ 𝑥 up<>) # 🐢\r\n", "r $ 𝑥 up # 🐢\r\n"),
        ("Change to forward", "r $ 𝑥 <>forwrd # 🐢\r\n", "r $ 𝑥 forward # 🐢\r\n"),
        ("Move the definition of 𝑥 up", "r $ <>𝑥\r\n𝑥 = up\r\n", "𝑥 = up\r\nr $ 𝑥\r\n"),
        ("Remove the definition and the other one", "<>𝑥 = up\r\n𝑦 = up # 🐢\r\nr $ up\r\n", "r $ up\r\n"),
    ],
)
def test_a_mistake_is_mended_at_its_place(client: Client, title: str, before: str, after: str) -> None:
    check(client, title, before, after)


def test_a_document_and_a_selection_get_their_layout() -> None:
    before = "# 🐢\r\nr   $ forward   left\r\ns   $ left ( right )\r\n"
    options = {"tabSize": 4, "insertSpaces": True}
    with Client({"onSave": "off"}) as client:
        client.open(URI, before)
        document = {"textDocument": {"uri": URI}, "options": options}
        whole = client.request("textDocument/formatting", document)
        assert applied(before, whole) == "# 🐢\r\nr $ forward left\r\ns $ left (right)\r\n"
        place = {"line": 1, "character": 3}
        part = client.request("textDocument/rangeFormatting", {**document, "range": {"start": place, "end": place}})
        assert applied(before, part) == "# 🐢\r\nr $ forward left\r\ns   $ left ( right )\r\n"
