"""What the server knows while it runs: the open documents, the settings, and what plays."""

from __future__ import annotations

from typing import Any

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, lsp_method

from improv_core import __version__
from improv_ls.documents import Document
from improv_ls.performance import Performance
from improv_ls.settings import Settings


class Session(LanguageServer):
    """One editor's session."""

    def __init__(self) -> None:
        super().__init__(
            "improv-ls",
            __version__,
            text_document_sync_kind=types.TextDocumentSyncKind.Incremental,
            protocol_cls=_Protocol,
        )
        self.settings = Settings()
        self.documents: dict[str, Document] = {}
        self.performance = Performance(self)
        self.page_shown = False
        self.wrong_settings: list[str] = []

    @property
    def encoding(self) -> types.PositionEncodingKind | str:
        """The unit of the columns, as agreed with the client."""
        return self.server_capabilities.position_encoding or types.PositionEncodingKind.Utf16

    def say(self, message: str, kind: types.MessageType = types.MessageType.Info) -> None:
        """Show one line to the person at the editor."""
        self.window_show_message(types.ShowMessageParams(kind, message))


class _Protocol(LanguageServerProtocol):
    """Leaves the text of documents to us: pygls keeps a copy too, and its way to edit it goes wrong after a form feed,
    after U+2028 and at the end of a file."""

    def _ours(self, method: str, params: Any) -> Any:
        if handler := self.fm.features.get(method):
            yield handler, (params,), None

    @lsp_method(types.TEXT_DOCUMENT_DID_OPEN)
    def lsp_text_document__did_open(self, params: types.DidOpenTextDocumentParams) -> Any:
        yield from self._ours(types.TEXT_DOCUMENT_DID_OPEN, params)

    @lsp_method(types.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(self, params: types.DidChangeTextDocumentParams) -> Any:
        yield from self._ours(types.TEXT_DOCUMENT_DID_CHANGE, params)

    @lsp_method(types.TEXT_DOCUMENT_DID_CLOSE)
    def lsp_text_document__did_close(self, params: types.DidCloseTextDocumentParams) -> Any:
        yield from self._ours(types.TEXT_DOCUMENT_DID_CLOSE, params)
