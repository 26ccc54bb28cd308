"""Compares each message from the server with `initialize`, and reports those that the client never supported.

By the specification, version 3.17. A pure function of the messages in both directions, so that it can itself be tested.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
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
_FIRST_ITEM_KINDS, _FIRST_SYMBOL_KINDS = range(1, 19), range(1, 19)
"""Kinds of the protocol's first version, which a client without its own list knows."""


def complaints(capabilities: Capabilities, log: Sequence[Spoken]) -> list[str]:
    """Return the messages that the client would not have expected, in the order in which they came."""
    asked: dict[object, Message] = {}
    tokens: dict[object, str] = {}  # of progress, and the latest message about each
    found: list[str] = []
    for by_server, message in log:
        method = message.get("method")
        if not by_server:
            if method and "id" in message:
                asked[message["id"]] = message
                tokens |= {token: "create" for token in [(message["params"] or {}).get("workDoneToken")] if token}
        elif method:
            said = list(_sent(capabilities, method, message.get("params"), tokens))
            found += [f"{method}: {each}" for each in said]
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
        yield from _diagnostics(capabilities, params["diagnostics"])
    elif method == "workspace/applyEdit":
        yield from _workspace_edit(capabilities, params["edit"])


def _registered_at(method: str) -> str:
    kind, _, name = method.rpartition("/")
    if name in ("didOpen", "didChange", "didClose", "didSave", "willSave", "willSaveWaitUntil"):
        return "textDocument.synchronization"
    if name.endswith("Files") and name != "didChangeWatchedFiles":
        return "workspace.fileOperations"
    return f"{kind}.{name}"


def _progress(params: Any, tokens: dict[object, str]) -> Iterator[str]:
    before, now = tokens.get(params["token"]), params["value"].get("kind")
    if now not in {None: (), "create": ("begin",), "end": ()}.get(before, ("report", "end")):
        yield f"{now} after {before}"
    tokens[params["token"]] = now


def _diagnostics(capabilities: Capabilities, found: Iterable[Message]) -> Iterator[str]:
    takes = "textDocument.publishDiagnostics"  # 3.17 has no others for diagnostics that are pulled
    for each in found:
        if not set(each.get("tags") or ()) <= set(said(capabilities, f"{takes}.tagSupport.valueSet") or ()):
            yield f"tags {each['tags']}"
        for name, need in (
            ("relatedInformation", "relatedInformation"),
            ("codeDescription", "codeDescriptionSupport"),
            ("data", "dataSupport"),
        ):
            if each.get(name) is not None and not said(capabilities, f"{takes}.{need}"):
                yield name
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
    if edit.get("changeAnnotations") and not said(capabilities, "workspace.workspaceEdit.changeAnnotationSupport"):
        yield "changeAnnotations"
    for edits in [each["edits"] for each in changes or () if "edits" in each] + list(edit.get("changes", {}).values()):
        yield from _text_edits(capabilities, edits)


def _text_edits(capabilities: Capabilities, edits: Sequence[Message] | None) -> Iterator[str]:
    def place(position: Message) -> tuple[int, int]:
        return position["line"], position["character"]

    spans = sorted((place(each["range"]["start"]), place(each["range"]["end"])) for each in edits or ())
    if any(start > end for start, end in spans) or any(one[1] > other[0] for one, other in pairwise(spans)):
        yield "edits that overlap"


def _initialized(capabilities: Capabilities, result: Any) -> Iterator[str]:
    serves = result["capabilities"]
    encodings = said(capabilities, "general.positionEncodings") or ["utf-16"]
    if serves.get("positionEncoding", "utf-16") not in encodings:
        yield f"columns in {serves['positionEncoding']}"
    for provider, need in (
        ("codeActionProvider", "textDocument.codeAction.codeActionLiteralSupport"),
        ("renameProvider", "textDocument.rename.prepareSupport"),
    ):
        if isinstance(serves.get(provider), Mapping) and not said(capabilities, need):
            yield f"{provider} with options"


def _content(capabilities: Capabilities, content: Any, takes: str) -> Iterator[str]:
    """Check text, or marked text: Markdown only for clients that take it."""
    if isinstance(content, Mapping) and content.get("kind") == "markdown":
        if "markdown" not in (said(capabilities, takes) or ()):
            yield "Markdown"
    elif isinstance(content, Mapping) and content.get("kind") != "plaintext":
        yield f"text of kind {content.get('kind')}"


def _hover(capabilities: Capabilities, result: Any) -> Iterator[str]:
    if result:
        yield from _content(capabilities, result["contents"], "textDocument.hover.contentFormat")


def _completion(capabilities: Capabilities, result: Any) -> Iterator[str]:
    if isinstance(result, Mapping):
        defaults = said(capabilities, "textDocument.completion.completionList.itemDefaults") or ()
        yield from (f"itemDefaults.{name}" for name in result.get("itemDefaults") or () if name not in defaults)
        result = result["items"]
    for item in result or ():
        yield from _item(capabilities, item)


_ITEM_FIELDS = {
    "commitCharacters": "commitCharactersSupport",
    "deprecated": "deprecatedSupport",
    "insertTextMode": "insertTextModeSupport",
    "labelDetails": "labelDetailsSupport",
    "preselect": "preselectSupport",
    "tags": "tagSupport",
}


def _item(capabilities: Capabilities, item: Message) -> Iterator[str]:
    takes = "textDocument.completion.completionItem"
    yield from _content(capabilities, item.get("documentation"), f"{takes}.documentationFormat")
    for name, need in _ITEM_FIELDS.items():
        if name in item and not said(capabilities, f"{takes}.{need}"):
            yield f"{name} of {item['label']}"
    if item.get("insertTextFormat") == 2 and not said(capabilities, f"{takes}.snippetSupport"):
        yield f"a snippet for {item['label']}"
    if "insert" in item.get("textEdit", {}) and not said(capabilities, f"{takes}.insertReplaceSupport"):
        yield f"insert and replace for {item['label']}"
    kinds = said(capabilities, "textDocument.completion.completionItemKind.valueSet") or _FIRST_ITEM_KINDS
    if item.get("kind", 1) not in kinds:
        yield f"kind {item['kind']} of {item['label']}"


def _signature(capabilities: Capabilities, result: Any) -> Iterator[str]:
    takes = "textDocument.signatureHelp.signatureInformation"
    for each in (result or {}).get("signatures", ()):
        yield from _content(capabilities, each.get("documentation"), f"{takes}.documentationFormat")
        if each.get("activeParameter") is not None and not said(capabilities, f"{takes}.activeParameterSupport"):
            yield "activeParameter of a signature"
        for parameter in each.get("parameters") or ():
            yield from _content(capabilities, parameter.get("documentation"), f"{takes}.documentationFormat")
            offsets = said(capabilities, f"{takes}.parameterInformation.labelOffsetSupport")
            if not isinstance(parameter["label"], str) and not offsets:
                yield "a label as offsets"


def _links(capabilities: Capabilities, result: Any) -> Iterator[str]:
    for each in result if isinstance(result, list) else ():
        if "targetUri" in each and not said(capabilities, "textDocument.definition.linkSupport"):
            yield "a link"


def _symbols(where: str) -> Check:
    def check(capabilities: Capabilities, result: Any) -> Iterator[str]:
        kinds = said(capabilities, f"{where}.symbolKind.valueSet") or _FIRST_SYMBOL_KINDS
        for each in result or ():
            if "location" not in each and not said(capabilities, f"{where}.hierarchicalDocumentSymbolSupport"):
                yield f"{each['name']} in a hierarchy"
            if each["kind"] not in kinds:
                yield f"kind {each['kind']} of {each['name']}"
            if "tags" in each and not said(capabilities, f"{where}.tagSupport"):
                yield f"tags of {each['name']}"
            yield from check(capabilities, each.get("children"))

    return check


def _actions(capabilities: Capabilities, result: Any) -> Iterator[str]:
    takes = "textDocument.codeAction"
    for each in result or ():
        if isinstance(each.get("command"), str):  # a command, which every client takes
            continue
        if not said(capabilities, f"{takes}.codeActionLiteralSupport"):
            yield f"an action that is no command: {each['title']}"
        for name in ("isPreferred", "disabled", "data"):
            if name in each and not said(capabilities, f"{takes}.{name}Support"):
                yield f"{name} of {each['title']}"
        if "edit" not in each and "command" not in each and not said(capabilities, f"{takes}.resolveSupport"):
            yield f"nothing to do for {each['title']}"
        yield from _workspace_edit(capabilities, each.get("edit", {}))
        yield from _diagnostics(capabilities, each.get("diagnostics") or ())


def _tokens(capabilities: Capabilities, result: Any) -> Iterator[str]:
    data = (result or {}).get("data") or ()
    length = 0
    for place in range(0, len(data), 5):
        if data[place] == 0 and place and data[place + 1] < length:
            yield "tokens that overlap"
        length = data[place + 2]


def _folds(capabilities: Capabilities, result: Any) -> Iterator[str]:
    if len(result or ()) > (said(capabilities, "textDocument.foldingRange.rangeLimit") or 5000):
        yield "more folds than it takes"
    for each in result or ():
        if "collapsedText" in each and not said(capabilities, "textDocument.foldingRange.foldingRange.collapsedText"):
            yield "collapsedText"


def _prepared(capabilities: Capabilities, result: Any) -> Iterator[str]:
    behaves = said(capabilities, "textDocument.rename.prepareSupportDefaultBehavior")
    if "defaultBehavior" in (result or {}) and not behaves:
        yield "defaultBehavior"


def _pulled(capabilities: Capabilities, result: Any) -> Iterator[str]:
    yield from _diagnostics(capabilities, result.get("items") or ())
    if result.get("relatedDocuments") and not said(capabilities, "textDocument.diagnostic.relatedDocumentSupport"):
        yield "relatedDocuments"


_ANSWERS: Mapping[str, Check] = {
    "initialize": _initialized,
    "completionItem/resolve": _item,
    "codeAction/resolve": lambda capabilities, result: _actions(capabilities, [result]),
    "textDocument/codeAction": _actions,
    "textDocument/completion": _completion,
    "textDocument/definition": _links,
    "textDocument/diagnostic": _pulled,
    "textDocument/documentSymbol": _symbols("textDocument.documentSymbol"),
    "textDocument/foldingRange": _folds,
    "textDocument/formatting": _text_edits,
    "textDocument/hover": _hover,
    "textDocument/onTypeFormatting": _text_edits,
    "textDocument/prepareRename": _prepared,
    "textDocument/rangeFormatting": _text_edits,
    "textDocument/rename": lambda capabilities, result: _workspace_edit(capabilities, result or {}),
    "textDocument/semanticTokens/full": _tokens,
    "textDocument/semanticTokens/range": _tokens,
    "textDocument/signatureHelp": _signature,
    "workspace/symbol": _symbols("workspace.symbol"),
}
