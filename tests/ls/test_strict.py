"""The checker of test_clients.py: it reports messages that a client never supported, and nothing else."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ls.client import Message, Spoken
from tests.ls.strict import complaints

RANGE = {"start": {"line": 0, "character": 0}, "end": {"line": 0, "character": 4}}
MARKED = {"kind": "markdown", "value": "**left**"}
ITEM: Message = {"label": "YZ"}
ACTION: Message = {"title": "Unroll", "edit": {}}
SYMBOL: Message = {"name": "x", "kind": 13}
EDIT: Message = {"range": RANGE, "newText": "up"}
MISTAKE: Message = {"range": RANGE, "message": "no"}


def progress(kind: str, token: str = "1") -> Spoken:
    return Spoken(True, {"method": "$/progress", "params": {"token": token, "value": {"kind": kind}}})


def sent(method: str, **params: Any) -> Spoken:
    return Spoken(True, {"method": method, "params": params})


def answered(method: str, answer: Any) -> list[Spoken]:
    asked = Spoken(False, {"id": 1, "method": method, "params": {}})
    return [asked, Spoken(True, {"id": 1, "result": answer})]


def capabilities(path: str, value: Any = True) -> dict[str, Any]:
    for name in reversed(path.split(".")):
        value = {name: value}
    return value  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("message", "need"),
    [
        (sent("window/workDoneProgress/create", token="1"), "window.workDoneProgress"),
        (sent("workspace/configuration", items=[]), "workspace.configuration"),
        (sent("window/showDocument", uri=""), "window.showDocument.support"),
        (sent("workspace/inlayHint/refresh"), "workspace.inlayHint.refreshSupport"),
        (sent("workspace/diagnostic/refresh"), "workspace.diagnostics.refreshSupport"),
        (sent("workspace/applyEdit", edit={}), "workspace.applyEdit"),
        (sent("improv/transport"), "experimental.improv"),
        (
            sent("client/registerCapability", registrations=[{"method": "workspace/didChangeConfiguration"}]),
            "workspace.didChangeConfiguration.dynamicRegistration",
        ),
        (
            sent("client/registerCapability", registrations=[{"method": "workspace/didRenameFiles"}]),
            "workspace.fileOperations.dynamicRegistration",
        ),
    ],
)
def test_requests_and_notifications_from_the_server(message: Spoken, need: str) -> None:
    assert len(complaints({}, [message])) == 1
    assert complaints(capabilities(need), [message]) == []


_ITEMS = "textDocument.completion.completionItem"
_ACTIONS = "textDocument.codeAction"


@pytest.mark.parametrize(
    ("method", "answer", "need"),
    [
        ("initialize", {"capabilities": {"renameProvider": {}}}, ("textDocument.rename.prepareSupport", True)),
        ("initialize", {"capabilities": {"positionEncoding": "utf-8"}}, ("general.positionEncodings", ["utf-8"])),
        ("textDocument/hover", {"contents": MARKED}, ("textDocument.hover.contentFormat", ["markdown"])),
        ("textDocument/completion", [{**ITEM, "insertTextFormat": 2}], (f"{_ITEMS}.snippetSupport", True)),
        ("textDocument/completion", {"items": [{**ITEM, "labelDetails": {}}]}, (f"{_ITEMS}.labelDetailsSupport", True)),
        (
            "textDocument/completion",
            [{**ITEM, "kind": 20}],
            ("textDocument.completion.completionItemKind.valueSet", [20]),
        ),
        ("completionItem/resolve", {**ITEM, "documentation": MARKED}, (f"{_ITEMS}.documentationFormat", ["markdown"])),
        (
            "textDocument/signatureHelp",
            {"signatures": [{"documentation": MARKED}]},
            ("textDocument.signatureHelp.signatureInformation.documentationFormat", ["markdown"]),
        ),
        ("textDocument/definition", [{"targetUri": ""}], ("textDocument.definition.linkSupport", True)),
        (
            "textDocument/documentSymbol",
            [SYMBOL],
            ("textDocument.documentSymbol.hierarchicalDocumentSymbolSupport", True),
        ),
        ("textDocument/codeAction", [ACTION], (f"{_ACTIONS}.codeActionLiteralSupport", {})),
        ("textDocument/rename", {"documentChanges": []}, ("workspace.workspaceEdit.documentChanges", True)),
        (
            "textDocument/diagnostic",
            {"items": [{**MISTAKE, "tags": [1]}]},
            ("textDocument.publishDiagnostics.tagSupport.valueSet", [1]),
        ),
        (
            "textDocument/diagnostic",
            {"items": [{**MISTAKE, "relatedInformation": []}]},
            ("textDocument.publishDiagnostics.relatedInformation", True),
        ),
    ],
)
def test_answers_from_the_server(method: str, answer: Any, need: tuple[str, Any]) -> None:
    said = complaints({}, answered(method, answer))
    assert [each.partition(":")[0] for each in said] == [method]
    path, value = need
    # An empty capability is one, too.
    assert complaints(capabilities(path, value or {"valueSet": []}), answered(method, answer)) == []


@pytest.mark.parametrize(
    "log",
    [
        [sent("textDocument/teleport")],
        [sent("window/showMessage", type=3, message="two\nlines")],
        [sent("window/showMessage", type=1, message="an error")],
        [Spoken(True, {"id": 7, "result": None})],
        [Spoken(False, {"id": 1, "method": "shutdown", "params": None}), Spoken(True, {"id": 1, "error": {}})],
        [progress("begin")],
        answered("textDocument/formatting", [EDIT, EDIT]),
        answered("textDocument/semanticTokens/full", {"data": [0, 0, 4, 0, 0, 0, 3, 1, 0, 0]}),
    ],
)
def test_unexpected_messages(log: list[Spoken]) -> None:
    assert len(complaints({}, log)) == 1


def test_a_file_is_created_only_if_the_client_can_create_files() -> None:
    edit = answered("textDocument/rename", {"documentChanges": [{"kind": "create"}]})
    assert len(complaints(capabilities("workspace.workspaceEdit.documentChanges"), edit)) == 1
    assert complaints(capabilities("workspace.workspaceEdit.resourceOperations", ["create"]), edit) == []


def test_progress_begins_continues_and_ends() -> None:
    create = sent("window/workDoneProgress/create", token="1")
    takes = capabilities("window.workDoneProgress")
    assert complaints(takes, [create, progress("begin"), progress("report"), progress("end")]) == []
    assert len(complaints(takes, [create, progress("begin"), progress("end"), progress("report")])) == 1
