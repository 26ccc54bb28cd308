"""One session with each of the editors that people use, according to their own `initialize`: clients/*.json.

The server may send nothing that an editor doesn't support. `python -m tests.ls.clients.record NAME` records one again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.ls.client import Client, span
from tests.ls.strict import complaints, said

RECORDS = sorted((Path(__file__).parent / "clients").glob("*.json"))
WRONG = "beat 60\r\n𝑥 = repeat 4 (forward left)\r\nr $ 𝑥 reflect YZ lft\r\nbeat 30\r\nidle = up\r\n"


@pytest.mark.parametrize("record", RECORDS, ids=lambda path: path.stem)
def test_session(record: Path, tmp_path: Path) -> None:
    about = json.loads(record.read_text(encoding="utf-8"))["initialize"]
    capabilities = about.pop("capabilities")
    shows_page = bool(said(capabilities, "window.showDocument.support"))
    settings = {"backend": "sim", "page": {"open": shows_page}, "inlayHints": {"beats": True}}
    about |= {
        "rootUri": tmp_path.as_uri(),
        "rootPath": str(tmp_path),
        "workspaceFolders": [{"uri": tmp_path.as_uri(), "name": "dances"}] if about.get("workspaceFolders") else None,
        "initializationOptions": settings,
    }
    with Client(capabilities=capabilities, configuration=settings, about=about) as client:
        session = Session(client, capabilities, (tmp_path / "dance.improv").as_uri())
        session.write()
        session.ask()
        session.play(shows_page)
    assert complaints(capabilities, client.log) == []


class Session:
    """Everything that a person does with one program."""

    def __init__(self, client: Client, capabilities: Mapping[str, Any], uri: str) -> None:
        self.client = client
        self.capabilities = capabilities
        self.uri = uri
        self.document = {"textDocument": {"uri": uri}}
        self.serves = client.initialized["capabilities"]
        unit = self.serves.get("positionEncoding", "utf-16")
        self.wide = {"utf-8": 4, "utf-16": 2, "utf-32": 1}[unit]
        """Columns of 𝑥."""

    def write(self) -> None:
        """Open a program with an error, look at it, and apply its fix, in columns of the agreed unit."""
        self.client.open(self.uri, WRONG)
        mistake, *others = self.diagnostics(1)
        wrong = span(2, 16 + self.wide, 19 + self.wide)
        assert (mistake["code"], mistake["range"]) == ("unknown-name", wrong)
        assert [other["code"] for other in others] == ["duplicate-beat", "unused-name"]
        context = {"diagnostics": [mistake], "only": ["quickfix"]}
        if "codeActionProvider" in self.serves:
            fix = self.request("textDocument/codeAction", range=wrong, context=context)[0]
            assert self.texts(fix["edit"]) == ["left"]
        rest = span(3, 0, 0, last=5)
        self.client.change(self.uri, 2, {"range": wrong, "text": "left"}, {"range": rest, "text": ""})
        assert self.diagnostics(2) == []

    def ask(self) -> None:
        """Ask everything about the words of the program."""
        name, plane, end = _place(1, 0), _place(2, 13 + self.wide), _place(2, 20 + self.wide)
        whole = {"start": _place(0, 0), "end": end}
        layout = {"tabSize": 2, "insertSpaces": True}
        hover = self.request("textDocument/hover", position=name)
        assert ("8 beats" in str(hover), hover["range"]) == (True, span(1, 0, self.wide))
        for place, label in ((end, "𝑥"), (plane, "YZ"), (_place(0, 0), "beat")):
            items = self.request("textDocument/completion", position=place)["items"]
            item = next(each for each in items if each["label"] == label)
            assert self.client.request("completionItem/resolve", item)["documentation"]
        assert self.request("textDocument/signatureHelp", position=plane)["signatures"]
        ranged = self.request("textDocument/semanticTokens/range", range=whole)
        full = self.request("textDocument/semanticTokens/full")
        assert ranged["data"] == full["data"]
        assert self.request("textDocument/semanticTokens/full/delta", previousResultId=full["resultId"])["edits"] == []
        assert len(self.request("textDocument/definition", position=name)) == 1
        assert len(self.request("textDocument/declaration", position=name)) == 1
        assert len(self.request("textDocument/references", position=name, context={"includeDeclaration": True})) == 2
        assert len(self.request("textDocument/documentHighlight", position=name)) == 2
        assert self.request("textDocument/prepareRename", position=name)
        (item,) = self.request("textDocument/prepareCallHierarchy", position=name)
        assert len(self.client.request("callHierarchy/incomingCalls", {"item": item})) == 1
        assert self.texts(self.request("textDocument/rename", position=name, newName="y")) == ["y", "y"]
        if "codeActionProvider" in self.serves:
            movement = span(1, 3 + self.wide, 9 + self.wide)
            assert self.request("textDocument/codeAction", range=movement, context={"diagnostics": []})
        assert self.request("textDocument/documentSymbol")
        assert self.client.request("workspace/symbol", {"query": "𝑥"})
        self.request("textDocument/foldingRange")
        assert self.request("textDocument/selectionRange", positions=[end])
        self.request("textDocument/formatting", options=layout)
        self.request("textDocument/rangeFormatting", range=whole, options=layout)
        if "inlayHintProvider" in self.serves:
            self.request("textDocument/inlayHint", range=whole)
        if "codeLensProvider" in self.serves:
            self.request("textDocument/codeLens")
        if "documentOnTypeFormattingProvider" in self.serves:
            self.request("textDocument/onTypeFormatting", position=end, ch="\n", options=layout)

    def play(self, shows_page: bool) -> None:
        """Save, see it play, set something, stop, close."""
        self.client.notify("textDocument/willSave", {**self.document, "reason": 1})
        self.client.save(self.uri)
        assert self.client.wait_for_line("▶") == "▶ r 9 beats, 9.0 s at beat 60, simulator"
        if said(self.capabilities, "experimental.improv"):
            assert self.client.wait("improv/lit")["ranges"]
            assert self.client.wait("improv/transport", lambda params: params["state"] == "playing")["uri"] == self.uri
        elif said(self.capabilities, "window.workDoneProgress"):
            self.client.wait("$/progress", lambda params: params["value"]["kind"] == "begin")
        if shows_page:
            assert len(self.client.wait_for_page()) == 1
        changed = {"improv": {"onSave": "sometimes", "inlayHints": {"beats": False}}}
        self.client.notify("workspace/didChangeConfiguration", {"settings": changed})
        self.client.wait_for_line("improv.onSave: expected")
        self.client.notify("workspace/didChangeConfiguration", {"settings": None})
        self.client.command("stop")
        self.client.notify("textDocument/didClose", self.document)

    def request(self, method: str, **params: Any) -> Any:
        return self.client.request(method, {**self.document, **params})

    def diagnostics(self, version: int) -> list[Any]:
        """Return the diagnostics: a client that pulls asks for them, if the server lets it."""
        if said(self.capabilities, "textDocument.diagnostic") and "diagnosticProvider" in self.serves:
            return list(self.request("textDocument/diagnostic")["items"])
        found = self.client.wait("textDocument/publishDiagnostics", lambda params: params["version"] == version)
        return list(found["diagnostics"])

    def texts(self, edit: Any) -> list[str]:
        """Return the new texts of an edit of the program."""
        if "changes" in edit:
            return [each["newText"] for each in edit["changes"][self.uri]]
        (changed,) = edit["documentChanges"]
        return [each["newText"] for each in changed["edits"]]


def _place(line: int, character: int) -> dict[str, int]:
    return {"line": line, "character": character}
