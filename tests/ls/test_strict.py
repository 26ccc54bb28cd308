"""The checker of test_clients.py: it reports messages that a client never supported, and nothing else."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ls.client import Message, Spoken, span
from tests.ls.strict import complaints

RANGE = span(0, 0, 4)
MARKED = {"kind": "markdown", "value": "**left**"}
ITEM: Message = {"label": "YZ"}
ACTION: Message = {"title": "Unroll", "edit": {}}
SYMBOL: Message = {"name": "x", "kind": 13}
EDIT: Message = {"range": RANGE, "newText": "up"}
_ITEM = "textDocument.completion.completionItem"
_NESTED = "textDocument.documentSymbol.hierarchicalDocumentSymbolSupport"
_OPERATIONS = "workspace.workspaceEdit.resourceOperations"


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
        (sent("workspace/configuration", items=[]), "workspace.configuration"),
        (
            sent("client/registerCapability", registrations=[{"method": "workspace/didRenameFiles"}]),
            "workspace.fileOperations.dynamicRegistration",
        ),
    ],
)
def test_messages_of_the_server_need_a_capability(message: Spoken, need: str) -> None:
    assert len(complaints({}, [message])) == 1
    assert complaints(capabilities(need), [message]) == []


@pytest.mark.parametrize(
    ("method", "answer", "need"),
    [
        ("initialize", {"capabilities": {"renameProvider": {}}}, ("textDocument.rename.prepareSupport", True)),
        ("textDocument/hover", {"contents": MARKED}, ("textDocument.hover.contentFormat", ["markdown"])),
        ("textDocument/completion", {"items": [{**ITEM, "insertTextFormat": 2}]}, (f"{_ITEM}.snippetSupport", True)),
        ("textDocument/completion", {"items": [{**ITEM, "kind": 20}]}, (f"{_ITEM}Kind.valueSet", [20])),
        ("completionItem/resolve", {**ITEM, "labelDetails": {}}, (f"{_ITEM}.labelDetailsSupport", True)),
        ("textDocument/documentSymbol", [SYMBOL], (_NESTED, True)),
        ("textDocument/codeAction", [ACTION], ("textDocument.codeAction.codeActionLiteralSupport", {"valueSet": []})),
        ("textDocument/rename", {"documentChanges": [{"kind": "create"}]}, (_OPERATIONS, ["create"])),
    ],
)
def test_answers_of_the_server_need_a_capability(method: str, answer: Any, need: tuple[str, Any]) -> None:
    said = complaints({}, answered(method, answer))
    assert {each.partition(":")[0] for each in said} == {method}
    assert complaints(capabilities(*need), answered(method, answer)) == []


@pytest.mark.parametrize(
    "log",
    [
        [sent("textDocument/teleport")],
        [sent("window/showMessage", type=3, message="two\nlines")],
        [Spoken(True, {"id": 7, "result": None})],
        [progress("begin")],
        answered("textDocument/formatting", [EDIT, EDIT]),
        answered("textDocument/foldingRange", [{"startLine": 0, "endLine": 1, "unheardOf": 1}]),
    ],
)
def test_an_unexpected_message_is_one_complaint(log: list[Spoken]) -> None:
    assert len(complaints({}, log)) == 1


def test_progress_begins_continues_and_ends() -> None:
    create = sent("window/workDoneProgress/create", token="1")
    takes = capabilities("window.workDoneProgress")
    assert complaints(takes, [create, progress("begin"), progress("report"), progress("end")]) == []
    assert len(complaints(takes, [create, progress("begin"), progress("end"), progress("report")])) == 1
