"""Fixes, refactorings and formatting as an editor asks for them, columns in UTF-16."""

from __future__ import annotations

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
        (change,) = found["Write forward"]["edit"]["documentChanges"]
        assert change["textDocument"] == {"uri": URI, "version": 1}
        assert applied(before, change["edits"]) == before.replace("forwrd", "forward")
        assert found["Write forward"]["diagnostics"][0]["code"] == "unknown-name"


@pytest.mark.parametrize(
    ("part", "after"),
    [
        ("Unroll", "# 🐢\nr $ (forward left forward left) up\n"),
        ("Wrap in [ ]", None),
    ],
)
def test_a_movement_is_written_differently(part: str, after: str | None) -> None:
    before = "# 🐢\nr $ repeat 2 (forward left) up\n"
    with Client({"onSave": "off"}) as client:
        client.open(URI, before)
        found = actions(client, 1, 6)
        (title,) = [title for title in found if title.startswith(part)]
        made = applied(before, found[title]["edit"]["changes"][URI])
        assert made != before
        if after:
            assert made.replace("(", "").replace(")", "") == after.replace("(", "").replace(")", "")


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
