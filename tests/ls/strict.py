"""Compares each message from the server with `initialize`, and reports what the client never supported.

By the specification, version 3.17. A pure function of the messages in both directions, so that it can itself be tested.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from tests.ls.client import Message, Spoken

Capabilities = Mapping[str, Any]
Check = Callable[[Capabilities, Any], Iterator[str]]

NEEDS = {
    "client/registerCapability": "dynamicRegistration of what is registered",
    "window/showDocument": "window.showDocument.support",
    "window/workDoneProgress/create": "window.workDoneProgress",
    "workspace/applyEdit": "workspace.applyEdit",
    "workspace/codeLens/refresh": "workspace.codeLens.refreshSupport",
    "workspace/configuration": "workspace.configuration",
    "workspace/diagnostic/refresh": "workspace.diagnostics.refreshSupport",
    "workspace/foldingRange/refresh": "workspace.foldingRange.refreshSupport",
    "workspace/inlayHint/refresh": "workspace.inlayHint.refreshSupport",
    "workspace/semanticTokens/refresh": "workspace.semanticTokens.refreshSupport",
    "workspace/workspaceFolders": "workspace.workspaceFolders",
    "improv/lit": "experimental.improv",
    "improv/transport": "experimental.improv",
}
"""Capability without which the server must not send a message."""

_ALWAYS = {
    *("$/progress", "window/showMessage", "window/showMessageRequest", "window/logMessage"),
    "textDocument/publishDiagnostics",
}
_FIRST_KINDS = range(1, 19)
"""Kinds of items and of symbols in the protocol's first version, which a client without its own list knows."""

_ACTION = "textDocument.codeAction"
_ITEM = "textDocument.completion.completionItem"
_PUBLISHED = "textDocument.publishDiagnostics"  # 3.17 has no other capabilities for diagnostics that are pulled
_SIGNATURE = "textDocument.signatureHelp.signatureInformation"
_FREE = {
    "action": "title kind edit command diagnostics",
    "diagnostic": "range severity code source message",
    "fold": "startLine endLine kind",
    "item": "label kind detail documentation sortText filterText insertText insertTextFormat textEdit data",
    "location": "uri range",
    "signature": "label documentation parameters",
    "symbol": "name kind detail range selectionRange location containerName children",
}
"""The fields of an object that every client takes, as far as the server sends them."""
_FIELDS = {
    "action": {name: f"{_ACTION}.{name}Support" for name in ("isPreferred", "disabled", "data")},
    "diagnostic": {
        "tags": f"{_PUBLISHED}.tagSupport.valueSet",
        "relatedInformation": f"{_PUBLISHED}.relatedInformation",
        "codeDescription": f"{_PUBLISHED}.codeDescriptionSupport",
        "data": f"{_PUBLISHED}.dataSupport",
    },
    "item": {"labelDetails": f"{_ITEM}.labelDetailsSupport"},
    "signature": {"activeParameter": f"{_SIGNATURE}.activeParameterSupport"},
}
"""The capability that each of the other fields needs. The server must send no field that is in neither table."""


def complaints(capabilities: Capabilities, log: Sequence[Spoken]) -> list[str]:
    """Return the messages that the client would not have expected, in the order in which they came."""
    asked: dict[object, Message] = {}
    tokens: dict[object, str] = {}  # of progress, and the latest message about each
    found: list[str] = []
    for by_server, message, _ in log:
        method = message.get("method")
        if not by_server:
            if method and "id" in message:
                asked[message["id"]] = message
                tokens |= {token: "create" for token in [(message["params"] or {}).get("workDoneToken")] if token}
        elif method:
            found += [f"{method}: {each}" for each in _sent(capabilities, method, message.get("params"), tokens)]
        elif message.get("id") not in asked:
            found.append(f"an answer that nobody asked for: {message}")
        elif "error" in message:
            found.append(f"{asked[message['id']]['method']}: {message['error']}")
        elif check := _ANSWERS.get(asked[message["id"]]["method"]):
            method = asked[message["id"]]["method"]
            found += [f"{method}: {each}" for each in check(capabilities, message["result"])]
    return found


def said(capabilities: Capabilities, path: str) -> Any:
    """Return the client's value at a path of names with dots; None if it sent none."""
    value: Any = capabilities
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def _sent(capabilities: Capabilities, method: str, params: Any, tokens: dict[object, str]) -> Iterator[str]:
    if method == "client/registerCapability":
        for each in params["registrations"]:
            if not said(capabilities, f"{_registered_at(each['method'])}.dynamicRegistration"):
                yield f"{each['method']} cannot be registered"
        return
    need = NEEDS.get(method)
    if need is None and method not in _ALWAYS:
        yield "unknown to it"
    # Rust's types, and with them Helix and Zed, drop a letter.
    if need and not said(capabilities, need) and not said(capabilities, need.replace("diagnostics.", "diagnostic.")):
        yield f"it never said {need}"
    if method == "window/workDoneProgress/create":
        tokens[params["token"]] = "create"
    elif method == "$/progress":
        yield from _progress(params, tokens)
    elif method == "window/showMessage":
        if "\n" in params["message"]:
            yield f"more than one line: {params['message']}"
        if params["type"] == 1:
            yield f"an error: {params['message']}"
    elif method == "textDocument/publishDiagnostics":
        yield from _diagnostics(capabilities, params)
    elif method == "workspace/applyEdit":
        yield from _workspace_edit(capabilities, params["edit"])


def _registered_at(method: str) -> str:
    kind, _, name = method.rpartition("/")
    if name.endswith("Files") and name != "didChangeWatchedFiles":
        return "workspace.fileOperations"
    return f"{kind}.{name}"


def _progress(params: Any, tokens: dict[object, str]) -> Iterator[str]:
    before, now = tokens.get(params["token"]), params["value"].get("kind")
    if now not in {None: (), "create": ("begin",), "end": ()}.get(before, ("report", "end")):
        yield f"{now} after {before}"
    tokens[params["token"]] = now


def _fields(capabilities: Capabilities, kind: str, given: Message) -> Iterator[str]:
    """Check the fields of an object of this kind."""
    needs = _FIELDS.get(kind, {})
    for name, value in given.items():
        allowed = name in _FREE[kind].split() or (name in needs and said(capabilities, needs[name]))
        if value is not None and not allowed:
            yield f"{name} of {given}"


def _diagnostics(capabilities: Capabilities, params: Any) -> Iterator[str]:
    for each in params.get("diagnostics") or params.get("items") or ():
        yield from _fields(capabilities, "diagnostic", each)
        if "\n" in each["message"]:
            yield f"more than one line: {each['message']}"


def _workspace_edit(capabilities: Capabilities, edit: Message) -> Iterator[str]:
    changes = edit.get("documentChanges")
    operations = said(capabilities, "workspace.workspaceEdit.resourceOperations") or ()
    if changes is not None and not operations and not said(capabilities, "workspace.workspaceEdit.documentChanges"):
        yield "documentChanges"
    for each in changes or ():
        if "kind" in each and each["kind"] not in operations:
            yield f"{each['kind']} of a file"
    for edits in [each["edits"] for each in changes or () if "edits" in each] + list(edit.get("changes", {}).values()):
        yield from _text_edits(capabilities, edits)


def _text_edits(_: Capabilities, edits: Sequence[Message] | None) -> Iterator[str]:
    def place(position: Message) -> tuple[int, int]:
        return position["line"], position["character"]

    spans = sorted((place(each["range"]["start"]), place(each["range"]["end"])) for each in edits or ())
    if any(start > end for start, end in spans) or any(one[1] > other[0] for one, other in pairwise(spans)):
        yield "edits that overlap"


def _initialized(capabilities: Capabilities, result: Any) -> Iterator[str]:
    serves = result["capabilities"]
    if serves.get("positionEncoding", "utf-16") not in (said(capabilities, "general.positionEncodings") or ["utf-16"]):
        yield f"columns in {serves['positionEncoding']}"
    for provider, need in (
        ("codeActionProvider", f"{_ACTION}.codeActionLiteralSupport"),
        ("renameProvider", "textDocument.rename.prepareSupport"),
    ):
        if isinstance(serves.get(provider), Mapping) and not said(capabilities, need):
            yield f"{provider} with options"


def _content(capabilities: Capabilities, content: Any, takes: str) -> Iterator[str]:
    """Check text, or marked text: Markdown only for clients that take it."""
    if isinstance(content, Mapping) and content["kind"] not in ("plaintext", *(said(capabilities, takes) or ())):
        yield f"text of kind {content['kind']}"


def _hover(capabilities: Capabilities, result: Any) -> Iterator[str]:
    yield from _content(capabilities, (result or {}).get("contents"), "textDocument.hover.contentFormat")


def _completion(capabilities: Capabilities, result: Any) -> Iterator[str]:
    for item in (result or {}).get("items", ()):
        yield from _item(capabilities, item)


def _item(capabilities: Capabilities, item: Message) -> Iterator[str]:
    yield from _fields(capabilities, "item", item)
    yield from _content(capabilities, item.get("documentation"), f"{_ITEM}.documentationFormat")
    if item.get("insertTextFormat") == 2 and not said(capabilities, f"{_ITEM}.snippetSupport"):
        yield f"a snippet for {item['label']}"
    kinds = said(capabilities, "textDocument.completion.completionItemKind.valueSet") or _FIRST_KINDS
    if item.get("kind", 1) not in kinds:
        yield f"kind {item['kind']} of {item['label']}"


def _signature(capabilities: Capabilities, result: Any) -> Iterator[str]:
    for each in (result or {}).get("signatures", ()):
        yield from _fields(capabilities, "signature", each)
        for described in (each, *each.get("parameters", ())):
            yield from _content(capabilities, described.get("documentation"), f"{_SIGNATURE}.documentationFormat")


def _each(kind: str) -> Check:
    def check(capabilities: Capabilities, result: Any) -> Iterator[str]:
        for each in result or ():
            yield from _fields(capabilities, kind, each)

    return check


def _symbols(where: str) -> Check:
    def check(capabilities: Capabilities, result: Any) -> Iterator[str]:
        kinds = said(capabilities, f"{where}.symbolKind.valueSet") or _FIRST_KINDS
        for each in result or ():
            yield from _fields(capabilities, "symbol", each)
            if "location" not in each and not said(capabilities, f"{where}.hierarchicalDocumentSymbolSupport"):
                yield f"{each['name']} in a hierarchy"
            if each["kind"] not in kinds:
                yield f"kind {each['kind']} of {each['name']}"
            yield from check(capabilities, each.get("children"))

    return check


def _actions(capabilities: Capabilities, result: Any) -> Iterator[str]:
    for each in result or ():
        if isinstance(each.get("command"), str):  # a command, which every client takes
            continue
        yield from _fields(capabilities, "action", each)
        if not said(capabilities, f"{_ACTION}.codeActionLiteralSupport"):
            yield f"an action that is no command: {each['title']}"
        if "edit" not in each and "command" not in each and not said(capabilities, f"{_ACTION}.resolveSupport"):
            yield f"nothing to do for {each['title']}"
        yield from _workspace_edit(capabilities, each.get("edit", {}))
        yield from _diagnostics(capabilities, each)


_ANSWERS: Mapping[str, Check] = {
    "initialize": _initialized,
    "completionItem/resolve": _item,
    "codeAction/resolve": lambda capabilities, result: _actions(capabilities, [result]),
    "textDocument/codeAction": _actions,
    "textDocument/completion": _completion,
    "textDocument/definition": _each("location"),
    "textDocument/diagnostic": _diagnostics,
    "textDocument/documentSymbol": _symbols("textDocument.documentSymbol"),
    "textDocument/foldingRange": _each("fold"),
    "textDocument/formatting": _text_edits,
    "textDocument/hover": _hover,
    "textDocument/onTypeFormatting": _text_edits,
    "textDocument/rangeFormatting": _text_edits,
    "textDocument/rename": lambda capabilities, result: _workspace_edit(capabilities, result or {}),
    "textDocument/signatureHelp": _signature,
    "workspace/symbol": _symbols("workspace.symbol"),
}
