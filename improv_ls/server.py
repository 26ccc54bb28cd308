"""The server on one screen: which method of LSP goes to which handler."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from lsprotocol import types

from improv_core.ide.semantic_tokens_legend import MODIFIERS, TYPES
from improv_ls.session import Session

FEATURES = {
    types.INITIALIZE: "lifecycle.initialize",
    types.INITIALIZED: "lifecycle.initialized",
    types.WORKSPACE_DID_CHANGE_CONFIGURATION: "lifecycle.did_change_configuration",
    types.WORKSPACE_DID_CHANGE_WATCHED_FILES: "documents.did_change_watched_files",
    types.WORKSPACE_DID_RENAME_FILES: "documents.did_rename_files",
    types.WORKSPACE_DID_DELETE_FILES: "documents.did_delete_files",
    types.TEXT_DOCUMENT_DID_OPEN: "documents.did_open",
    types.TEXT_DOCUMENT_DID_CHANGE: "documents.did_change",
    types.TEXT_DOCUMENT_DID_CLOSE: "documents.did_close",
    types.TEXT_DOCUMENT_DIAGNOSTIC: "diagnostics.diagnostic",
    types.TEXT_DOCUMENT_HOVER: "language.hover",
    types.TEXT_DOCUMENT_COMPLETION: "language.completion",
    types.COMPLETION_ITEM_RESOLVE: "language.resolve",
    types.TEXT_DOCUMENT_SIGNATURE_HELP: "language.signature_help",
    types.TEXT_DOCUMENT_CODE_ACTION: "actions.code_action",
    types.TEXT_DOCUMENT_CODE_LENS: "hints.code_lens",
    types.TEXT_DOCUMENT_INLAY_HINT: "hints.inlay_hint",
    types.TEXT_DOCUMENT_FORMATTING: "layout.formatting",
    types.TEXT_DOCUMENT_RANGE_FORMATTING: "layout.range_formatting",
    types.TEXT_DOCUMENT_ON_TYPE_FORMATTING: "layout.on_type_formatting",
    types.TEXT_DOCUMENT_DEFINITION: "navigation.definition",
    types.TEXT_DOCUMENT_REFERENCES: "navigation.references",
    types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT: "navigation.document_highlight",
    types.TEXT_DOCUMENT_PREPARE_RENAME: "navigation.prepare_rename",
    types.TEXT_DOCUMENT_RENAME: "navigation.rename",
    types.TEXT_DOCUMENT_DOCUMENT_SYMBOL: "structure.document_symbol",
    types.TEXT_DOCUMENT_SELECTION_RANGE: "structure.selection_range",
    types.TEXT_DOCUMENT_FOLDING_RANGE: "structure.folding_range",
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: "colors.semantic_tokens",
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL_DELTA: "colors.semantic_tokens_delta",
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE: "colors.semantic_tokens_range",
    types.TEXT_DOCUMENT_WILL_SAVE: "playback.will_save",
    types.TEXT_DOCUMENT_DID_SAVE: "playback.did_save",
    "improv/moments": "playback.moments",
}
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
        inter_file_dependencies=True, workspace_diagnostics=False, identifier="improv"
    ),
    types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL: types.SemanticTokensLegend(TYPES, MODIFIERS),
    types.TEXT_DOCUMENT_COMPLETION: types.CompletionOptions(trigger_characters=[" "], resolve_provider=True),
    types.TEXT_DOCUMENT_CODE_ACTION: types.CodeActionOptions(
        [
            types.CodeActionKind.QuickFix,
            types.CodeActionKind.RefactorExtract,
            types.CodeActionKind.RefactorInline,
            types.CodeActionKind.RefactorRewrite,
        ]
    ),
    types.TEXT_DOCUMENT_ON_TYPE_FORMATTING: types.DocumentOnTypeFormattingOptions("\n", [")", "]"]),
    types.TEXT_DOCUMENT_SIGNATURE_HELP: types.SignatureHelpOptions(trigger_characters=[" ", "("]),
}
COMMANDS = {
    "improv.play": "playback.play",
    "improv.restart": "playback.restart",
    "improv.hush": "playback.hush",
    "improv.pause": "playback.pause",
    "improv.resume": "playback.resume",
    "improv.seek": "playback.seek",
    "improv.speed": "playback.speed",
    "improv.mute": "playback.mute",
    "improv.solo": "playback.solo",
}


def create_server() -> Session:
    """A server with every feature; it waits for a client."""
    server = Session()
    for method, place in FEATURES.items():
        server.feature(method, OPTIONS.get(method))(_handler(place))
    for name, place in COMMANDS.items():
        server.command(name)(_handler(place))
    server.command("improv.page")(_page)
    server.feature(types.WORKSPACE_SYMBOL)(_workspace_symbol)
    server.feature(types.SHUTDOWN)(_shutdown)
    return server


def serve() -> None:
    """Serve one editor over standard input and output."""
    # Editors show standard error as errors, and every message that matters reaches the person through LSP.
    logging.basicConfig(level=logging.CRITICAL)
    create_server().start_io()


def _handler(place: str) -> Callable[..., Any]:
    """A handler whose room is entered when it is first needed: an editor waits for nothing but `initialize`."""
    room, name = place.split(".")

    def handle(ls: Session, *arguments: Any) -> Any:
        return getattr(import_module(f"improv_ls.handlers.{room}"), name)(ls, *arguments)

    return handle


async def _workspace_symbol(ls: Session, params: types.WorkspaceSymbolParams) -> list[types.SymbolInformation]:
    """Files are read beside the event loop, so that typing goes on."""
    search = import_module("improv_ls.handlers.structure").workspace_symbols
    documents = list(ls.documents.values())
    given_up = threading.Event()
    try:
        found: list[types.SymbolInformation] = await asyncio.to_thread(
            search, documents, ls.folders, params.query, ls.encoding, given_up.is_set
        )
    finally:
        given_up.set()
    return found


async def _page(ls: Session, *arguments: Any) -> str | None:
    """The answer waits until there is a page."""
    return await ls.performance.show_page()


async def _shutdown(ls: Session, params: None) -> None:
    """The answer waits until the robots stand."""
    await ls.close()
