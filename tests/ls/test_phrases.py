"""Phrases with parameters and scenes, as an editor sees them; columns in UTF-16."""

from __future__ import annotations

from typing import Any

from tests.ls.client import CAPABILITIES, Client

URI = "untitled:Untitled-1"
DOCUMENT = {"textDocument": {"uri": URI}}
PROGRAM = "# 𝑛 times.\r\ntimes 𝑛 (m) = repeat 𝑛 m\r\nr $ times 2 up\r\n---\r\nr s $ times 3 \r\n"
ABLE = {
    **CAPABILITIES,
    "textDocument": {
        "completion": {"completionItem": {"snippetSupport": True}},
        "documentSymbol": {"hierarchicalDocumentSymbolSupport": True},
        "hover": {"contentFormat": ["plaintext"]},
    },
}


def at(line: int, character: int) -> dict[str, Any]:
    return {**DOCUMENT, "position": {"line": line, "character": character}}


def completed(client: Client, label: str) -> str:
    found = client.request("textDocument/completion", at(4, 6))
    return next(str(item["textEdit"]["newText"]) for item in found["items"] if item["label"] == label)


def test_an_editor_that_takes_all() -> None:
    with Client(capabilities=ABLE) as client:
        client.open(URI, PROGRAM)
        assert completed(client, "times") == "times ${1:𝑛}"
        signature = client.request("textDocument/signatureHelp", at(4, 14))
        assert signature["signatures"][0]["label"] == "times 𝑛 (m)"
        assert signature["signatures"][0]["documentation"] == "𝑛 times."
        assert signature["activeParameter"] == 1
        hover = client.request("textDocument/hover", at(2, 5))
        assert hover["contents"]["value"].startswith(
            "times 2 (phrase, line 2)\n# 𝑛 times.\ntimes 𝑛 (m) = repeat 𝑛 m\n2 beats"
        )
        renamed = client.request("textDocument/rename", {**at(1, 6), "newName": "k"})
        edits = renamed["changes"][URI]
        assert [(edit["range"]["start"]["character"], edit["range"]["end"]["character"]) for edit in edits] == [
            (6, 8),
            (22, 24),
        ]
        first, second = client.request("textDocument/documentSymbol", DOCUMENT)
        assert [part["name"] for part in first["children"]] == ["times", "r"]
        assert (second["name"], second["detail"]) == ("scene 2", "from beat 2")
        assert [part["name"] for part in second["children"][0]["children"]] == ["r", "s"]


def test_an_editor_that_takes_little() -> None:
    with Client() as client:
        client.open(URI, PROGRAM)
        assert completed(client, "times") == "times"
        found = client.request("textDocument/documentSymbol", DOCUMENT)
        assert [each["name"] for each in found] == ["times", "r", "r", "s"]
