"""The server on one screen: the handler of each method of LSP."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import cache, partial
from importlib import import_module
from typing import Any

from lsprotocol import types

from improv_core.ide.semantic_tokens_legend import MODIFIERS, TYPES
from improv_ls.session import Session, uri_of

FEATURES = {
    types.INITIALIZE: "initialize.initialize",
    types.INITIALIZED: "initialize.initialized",
    types.WORKSPACE_DID_CHANGE_CONFIGURATION: "did_change_configuration.did_change_configuration",
    types.WORKSPACE_DID_CHANGE_WATCHED_FILES: "workspace_files.did_change_watched_files",
    types.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS: "workspace_files.did_change_workspace_folders",
    types.WORKSPACE_DID_RENAME_FILES: "workspace_files.did_rename_files",
    types.WORKSPACE_DID_DELETE_FILES: "workspace_files.did_delete_files",
    types.TEXT_DOCUMENT_DID_OPEN: "text_document_sync.did_open",
    types.TEXT_DOCUMENT_DID_CHANGE: "text_document_sync.did_change",
    types.TEXT_DOCUMENT_DID_CLOSE: "text_document_sync.did_close",
    types.TEXT_DOCUMENT_WILL_SAVE: "text_document_sync.will_save",
    types.TEXT_DOCUMENT_DID_SAVE: "text_document_sync.did_save",
    types.TEXT_DOCUMENT_DIAGNOSTIC: "diagnostics.diagnostic",
    types.WORKSPACE_DIAGNOSTIC: "workspace_diagnostic.workspace_diagnostic",
    types.TEXT_DOCUMENT_HOVER: "hover.hover",
    types.TEXT_DOCUMENT_COMPLETION: "completion.completion",
    types.COMPLETION_ITEM_RESOLVE: "completion.resolve",
    types.TEXT_DOCUMENT_SIGNATURE_HELP: "hover.signature_help",
    types.TEXT_DOCUMENT_CODE_ACTION: "code_action.code_action",
    types.CODE_ACTION_RESOLVE: "code_action.resolve",
    types.TEXT_DOCUMENT_CODE_LENS: "inlay_hint.code_lens",
    types.TEXT_DOCUMENT_INLAY_HINT: "inlay_hint.inlay_hint",
    types.TEXT_DOCUMENT_FORMATTING: "formatting.formatting",
    types.TEXT_DOCUMENT_RANGE_FORMATTING: "formatting.range_formatting",
    types.TEXT_DOCUMENT_ON_TYPE_FORMATTING: "formatting.on_type_formatting",
    types.TEXT_DOCUMENT_DECLARATION: "references.definition",
    types.TEXT_DOCUMENT_DEFINITION: "references.definition",
    types.TEXT_DOCUMENT_REFERENCES: "references.references",
    types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: "references.document_highlight",
    types.TEXT_DOCUMENT_PREPARE_RENAME: "rename.prepare_rename",
    types.TEXT_DOCUMENT_RENAME: "rename.rename",
    types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY: "call_hierarchy.prepare",
    types.CALL_HIERARCHY_INCOMING_CALLS: "call_hierarchy.incoming",
    types.CALL_HIERARCHY_OUTGOING_CALLS: "call_hierarchy.outgoing",
    types.TEXT_DOCUMENT_DOCUMENT_SYMBOL: "structure.document_symbol",
    types.TEXT_DOCUMENT_SELECTION_RANGE: "structure.selection_range",
    types.TEXT_DOCUMENT_FOLDING_RANGE: "structure.folding_range",
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: "semantic_tokens.semantic_tokens",
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL_DELTA: "semantic_tokens.semantic_tokens_delta",
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE: "semantic_tokens.semantic_tokens_range",
    types.WORKSPACE_SYMBOL: "workspace_symbol.workspace_symbol",
}
IN_ROBOTS_FILES = {
    types.TEXT_DOCUMENT_DECLARATION: "robots_file.declaration",
    types.TEXT_DOCUMENT_DEFINITION: "robots_file.definition",
    types.TEXT_DOCUMENT_REFERENCES: "robots_file.references",
    types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: "robots_file.document_highlight",
    **{
        method: FEATURES[method]
        for method in (
            *(types.TEXT_DOCUMENT_HOVER, types.TEXT_DOCUMENT_COMPLETION, types.TEXT_DOCUMENT_CODE_ACTION),
            *(types.TEXT_DOCUMENT_FORMATTING, types.TEXT_DOCUMENT_RANGE_FORMATTING),
            *(types.TEXT_DOCUMENT_PREPARE_RENAME, types.TEXT_DOCUMENT_RENAME, types.TEXT_DOCUMENT_DOCUMENT_SYMBOL),
            *(types.TEXT_DOCUMENT_SELECTION_RANGE, types.TEXT_DOCUMENT_FOLDING_RANGE),
        )
    },
}
"""The handlers of requests about an `improv.toml`; other requests about documents are for programs alone."""
_FILES = types.FileOperationRegistrationOptions(
    [
        types.FileOperationFilter(types.FileOperationPattern("**/*.{improv,toml}"), "file"),
        types.FileOperationFilter(types.FileOperationPattern("**", types.FileOperationPatternKind.Folder), "file"),
    ]
)
OPTIONS: Mapping[str, Any] = {
    types.WORKSPACE_DID_RENAME_FILES: _FILES,
    types.WORKSPACE_DID_DELETE_FILES: _FILES,
    types.TEXT_DOCUMENT_DIAGNOSTIC: types.DiagnosticOptions(
        inter_file_dependencies=True, workspace_diagnostics=True, identifier="improv"
    ),
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: types.SemanticTokensLegend(TYPES, MODIFIERS),
    types.TEXT_DOCUMENT_COMPLETION: types.CompletionOptions(trigger_characters=[" ", '"'], resolve_provider=True),
    types.TEXT_DOCUMENT_CODE_ACTION: types.CodeActionOptions(
        [
            types.CodeActionKind.QuickFix,
            types.CodeActionKind.RefactorExtract,
            types.CodeActionKind.RefactorInline,
            types.CodeActionKind.RefactorRewrite,
            "source.fixAll.improv",
            *("improv.play", "improv.stop", "improv.mute", "improv.solo", "improv.resume", "improv.onSave"),
        ]
    ),
    types.TEXT_DOCUMENT_ON_TYPE_FORMATTING: types.DocumentOnTypeFormattingOptions("\n", [")", "]"]),
    types.TEXT_DOCUMENT_SIGNATURE_HELP: types.SignatureHelpOptions(trigger_characters=[" ", "("]),
}
COMMANDS = {
    f"improv.{name}": f"execute_command.{name}"
    for name in (
        *("play", "only", "before", "history", "restart", "stop", "pause", "resume", "anyway", "cue", "key"),
        *("seek", "speed", "mute", "solo", "page", "calibrate", "transcribe"),
    )
} | {"improv.hush": "execute_command.stop", "improv.onSave": "execute_command.on_save"}
_ASYNCHRONOUS = {
    FEATURES[types.WORKSPACE_SYMBOL],
    FEATURES[types.WORKSPACE_DIAGNOSTIC],
    COMMANDS["improv.page"],
    COMMANDS["improv.history"],
    COMMANDS["improv.transcribe"],
}


_NOTHING: Mapping[str, Any] = {
    **dict.fromkeys((types.TEXT_DOCUMENT_HOVER, types.TEXT_DOCUMENT_COMPLETION, types.TEXT_DOCUMENT_SIGNATURE_HELP)),
    **dict.fromkeys((types.TEXT_DOCUMENT_PREPARE_RENAME, types.TEXT_DOCUMENT_RENAME)),
    **dict.fromkeys(method for method in FEATURES if method.startswith("textDocument/semanticTokens/")),
    types.TEXT_DOCUMENT_DIAGNOSTIC: types.RelatedFullDocumentDiagnosticReport([]),
}
"""The answers about documents that we don't know, unless they are empty lists."""
_REQUESTS = {method for method in FEATURES if types.METHOD_TO_TYPES.get(method, (None, method))[1]}


def create_server() -> Session:
    """Create a server with every feature; it waits for a client."""
    server = Session()
    server.publish = partial(_loaded_later("diagnostics.publish"), server)
    server.urdfs_changed = partial(_loaded_later("workspace_files.urdfs_changed"), server)
    for method, handler in FEATURES.items():
        about_document = method in _REQUESTS and method.startswith(("textDocument/", "callHierarchy/"))
        handle = _about_document(method) if about_document else _loaded_later(handler)
        server.feature(method, OPTIONS.get(method))(handle)
        if handler not in _ASYNCHRONOUS and method in _REQUESTS and method != types.INITIALIZE:
            server.sliced.add(method)
    for name, handler in COMMANDS.items():
        server.command(name)(_loaded_later(handler))
    return server


def serve() -> int:
    """Serve one editor over standard input and output. Return the exit code."""
    # Editors show standard error as errors, and every message that matters reaches the person through LSP.
    logging.basicConfig(level=logging.CRITICAL)
    # Under `PYTHONUNBUFFERED`, `sys.stdout` has no buffer: if the process is halted while it writes to a full pipe, the
    # rest of the message is lost.
    with open(1, "wb", closefd=False) as output:
        return create_server().serve(0, output)


def _about_document(method: str) -> Callable[..., Any]:
    """Wrap the handlers of a request about a document: that for programs, and that for `improv.toml`, if any."""
    for_program = _loaded_later(FEATURES[method])
    for_file = _loaded_later(IN_ROBOTS_FILES[method]) if method in IN_ROBOTS_FILES else None

    def handle(ls: Session, params: Any) -> Any:
        uri = uri_of(params) or ""
        if document := ls.documents.get(uri):
            return for_program(ls, document, params)
        if for_file and (file := ls.robots_files.get(uri)):
            return for_file(ls, file, params)
        return _NOTHING.get(method, [])

    return handle


def _loaded_later(handler: str) -> Callable[..., Any]:
    """Wrap a handler whose module is imported when it is first needed: an editor waits for nothing but `initialize`."""
    module, name = handler.split(".")
    loaded = cache(lambda: getattr(import_module(f"improv_ls.handlers.{module}"), name))

    def handle(ls: Session, *arguments: Any) -> Any:
        return loaded()(ls, *arguments)

    async def handle_later(ls: Session, *arguments: Any) -> Any:
        return await handle(ls, *arguments)

    return handle_later if handler in _ASYNCHRONOUS else handle
