"""What the server knows while it runs: the open documents, the settings, and what plays."""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from collections.abc import Coroutine
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any

from lsprotocol import types
from pygls.io_ import StdoutWriter, run_async
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, lsp_method

from improv_core import __version__
from improv_ls.settings import Settings

if TYPE_CHECKING:
    from improv_ls.documents import Document
    from improv_ls.performance import Performance

ANSWER_LIMIT = 2.0
"""Seconds to wait for a client's answer: some never answer."""


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
        self.page_shown = False
        self._tasks: set[asyncio.Task[None]] = set()  # the loop itself keeps none of them alive
        self.wrong_settings: list[str] = []

    @cached_property
    def performance(self) -> Performance:
        """What plays. Made when something is to play: it brings much along."""
        from improv_ls.performance import Performance

        return Performance(self)

    async def close(self) -> None:
        """Stop the robots, if any have been moved, and end the stages."""
        if "performance" in self.__dict__:
            await self.performance.close()

    @property
    def encoding(self) -> types.PositionEncodingKind | str:
        """The unit of the columns, as agreed with the client."""
        return self.server_capabilities.position_encoding or types.PositionEncodingKind.Utf16

    def soon(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something that takes a while, after the message at hand. pygls starts asynchronous handlers later, too,
        but then messages that come in the meantime would overtake what a handler does first."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def say(self, message: str, kind: types.MessageType = types.MessageType.Info) -> None:
        """Show one line to the person at the editor."""
        self.window_show_message(types.ShowMessageParams(kind, message))

    def start_io(self, stdin: Any = None, stdout: Any = None) -> None:
        """Serve over the standard streams. pygls reads each line on a thread of a pool; ours reads what there is."""
        self._stop_event = threading.Event()
        self.protocol.set_writer(StdoutWriter(sys.stdout.buffer))
        try:
            asyncio.run(self._serve())
        except (BrokenPipeError, KeyboardInterrupt, SystemExit):
            pass
        finally:
            self.shutdown()  # type: ignore[no-untyped-call]

    async def _serve(self) -> None:
        loop = asyncio.get_running_loop()
        reader = asyncio.StreamReader(limit=LONGEST_HEADER)

        def read() -> None:
            # Not through sys.stdin: its lock, held by a thread that waits, would keep Python from ending.
            while data := os.read(0, READ_SIZE):
                loop.call_soon_threadsafe(reader.feed_data, data)
            loop.call_soon_threadsafe(reader.feed_eof)

        threading.Thread(target=read, daemon=True).start()
        assert self._stop_event
        with suppress(asyncio.IncompleteReadError):  # the client ended in the middle of a message
            await run_async(self._stop_event, reader, self.protocol, error_handler=self.report_server_error)


READ_SIZE = 65_536
LONGEST_HEADER = 2**16


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
