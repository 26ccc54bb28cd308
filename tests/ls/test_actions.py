"""Fixes, refactorings and formatting for an editor, columns in UTF-16."""

from __future__ import annotations

from typing import Any

from tests.ls.client import CAPABILITIES, Client

URI = "file:///dance.improv"
VERSIONED = {**CAPABILITIES, "workspace": {"workspaceEdit": {"documentChanges": True}}}


def applied(text: str, edits: list[dict[str, Any]]) -> str:
    """Return the text after edits whose columns count UTF-16 units."""
    lines = [line.encode("utf-16-le") for line in text.splitlines(keepends=True)]

    def offset(position: dict[str, int]) -> int:
        return sum(map(len, lines[: position["line"]])) + 2 * position["character"]

    whole = text.encode("utf-16-le")
    for edit in sorted(edits, key=lambda edit: offset(edit["range"]["start"]), reverse=True):
        start, end = offset(edit["range"]["start"]), offset(edit["range"]["end"])
        whole = whole[:start] + edit["newText"].encode("utf-16-le") + whole[end:]
    return whole.decode("utf-16-le")


def actions(client: Client, line: int, column: int, **context: Any) -> dict[str, dict[str, Any]]:
    return {action["title"]: action for action in client.actions(URI, line, column, **context)}


def test_an_error_is_fixed() -> None:
    before = "# 🐢\r\nr $ forward (  # 🐢\r\nforwrd)\r\n"
    with Client({"onSave": "off"}, capabilities=VERSIONED) as client:
        client.open(URI, before)
        found = actions(client, 2, 3, only=["quickfix"])
        (change,) = found["Change to forward"]["edit"]["documentChanges"]
        assert change["textDocument"] == {"uri": URI, "version": 1}
        assert applied(before, change["edits"]) == before.replace("forwrd", "forward")
        assert found["Change to forward"]["diagnostics"][0]["code"] == "unknown-name"


def test_slow_edits_are_computed_when_an_action_is_chosen() -> None:
    lines = [f"n{number} = left | up\r\n" for number in range(30)]
    asks = {"resolveSupport": {"properties": ["edit"]}, "dataSupport": True}
    literals: dict[str, Any] = {"codeActionLiteralSupport": {"codeActionKind": {"valueSet": []}}}
    capable = {**VERSIONED, "textDocument": {**VERSIONED["textDocument"], "codeAction": {**literals, **asks}}}
    many = "Remove the definition and all 29 others of this kind"
    with Client({"onSave": "off"}, capabilities=capable) as client:
        client.open(URI, "".join(lines))
        found = actions(client, 0, 0, only=["quickfix"])
        assert [title for title, action in found.items() if "edit" not in action] == [many]
        client.change(URI, 2, {"text": "".join(lines[:25])})
        assert "edit" not in client.request("codeAction/resolve", found[many])  # nothing has this title now
        client.change(URI, 3, {"text": "# 🐢\r\n" + "".join(lines)})
        found = actions(client, 1, 0)
        (change,) = client.request("codeAction/resolve", found[many])["edit"]["documentChanges"]
        assert change["textDocument"]["version"] == 3
        assert applied("# 🐢\r\n" + "".join(lines), change["edits"]).strip() == "# 🐢"
        assert actions(client, 0, 0, only=["source.organizeImports"]) == {}
        ((title, action),) = actions(client, 0, 0, only=["source.fixAll"]).items()
        assert action["kind"] == "source.fixAll.improv"
        assert title == "Fix all that is safe to fix"  # at once: Neovim applies it without asking for its edits
        (change,) = action["edit"]["documentChanges"]
        assert "left || up" in applied("# 🐢\r\n" + "".join(lines), change["edits"])
        client.change(URI, 4, {"text": "r $ left\r\n"})
        assert actions(client, 0, 0, only=["source.fixAll"]) == {}
    with Client({"onSave": "off"}, capabilities=VERSIONED) as client:  # which can't ask later
        client.open(URI, "".join(lines))
        assert "edit" in actions(client, 0, 0)[many]


def test_a_document_and_a_selection_are_formatted() -> None:
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
