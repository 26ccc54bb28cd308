"""What the server knows while it runs: the open documents, the settings, and what plays."""

from __future__ import annotations

import asyncio
import json
import os
import sys
import threading
from collections.abc import Collection, Coroutine, Iterator, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from lsprotocol import types
from pygls.capabilities import get_capability
from pygls.exceptions import JsonRpcException, JsonRpcRequestCancelled
from pygls.io_ import StdoutWriter
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol
from pygls.uris import to_fs_path

from improv_core import __version__
from improv_ls.framing import Frames
from improv_ls.positions import Encoding
from improv_ls.settings import Settings

if TYPE_CHECKING:
    from improv_ls.coloring import Coloring
    from improv_ls.documents import Document
    from improv_ls.handlers.diagnostics import Report
    from improv_ls.performance import Performance
    from improv_ls.to_lsp import Takes

ANSWER_LIMIT = 2.0
"""Seconds to wait for a client's answer: some never answer."""


class Session(LanguageServer):
    """One editor's session."""

    protocol: Protocol

    def __init__(self) -> None:
        super().__init__(
            "improv-ls",
            __version__,
            text_document_sync_kind=types.TextDocumentSyncKind.Incremental,
            protocol_cls=Protocol,
        )
        self.settings = Settings()
        self.documents: dict[str, Document] = {}
        self.colorings: dict[str, Coloring] = {}
        self.reports: dict[str, Report] = {}
        self.saved_by_themselves: set[str] = set()
        self.page_shown = False
        self._tasks: set[asyncio.Task[None]] = set()  # the loop itself keeps none of them alive
        self.wrong_settings: list[str] = []
        """What is wrong with the settings as they were last given."""
        self.ended = asyncio.Event()
        """Set once there is nobody left to serve."""

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
    def encoding(self) -> Encoding:
        """The unit of the columns, as agreed with the client."""
        return self.server_capabilities.position_encoding or types.PositionEncodingKind.Utf16

    @property
    def folders(self) -> list[Path]:
        """The folders that the editor works in, as far as they are on this machine."""
        uris = [folder.uri for folder in self.workspace.folders.values()] or [self.workspace.root_uri or ""]
        return [Path(path) for uri in uris if uri.startswith("file:") and (path := to_fs_path(uri))]

    @property
    def shows_live(self) -> bool:
        """Whether the client has asked for messages of our own, by `experimental: {"improv": true}`."""
        asked = self.client_capabilities.experimental
        asked = asked.get("improv") if isinstance(asked, dict) else getattr(asked, "improv", None)
        return bool(asked)

    @cached_property
    def pulls(self) -> bool:
        """Whether the client asks for diagnostics, and can be told to ask again when `improv.toml` has changed."""
        asks = get_capability(self.client_capabilities, "text_document.diagnostic") is not None
        return asks and bool(get_capability(self.client_capabilities, "workspace.diagnostics.refresh_support"))

    @cached_property
    def takes(self) -> Takes:
        """What the client takes of a diagnostic. Clients that ask may say so, as they did before they could, for
        those that are sent."""
        from improv_ls.to_lsp import Takes

        def said(what: str) -> bool:
            places = ("publish_diagnostics", "diagnostic")
            return any(get_capability(self.client_capabilities, f"text_document.{place}.{what}") for place in places)

        return Takes(said("related_information"), said("tag_support"))

    def ask_again(self, feature: Literal["code_lens", "diagnostics", "inlay_hint"]) -> None:
        """Have the client ask again for what it shows, where it can be told to."""
        if get_capability(self.client_capabilities, f"workspace.{feature}.refresh_support"):
            self.protocol.send_request(_REFRESHES[feature])

    def soon(self, work: Coroutine[Any, Any, None]) -> None:
        """Do something that takes a while, after the message at hand. pygls starts asynchronous handlers later, too,
        but then messages that come in the meantime would overtake what a handler does first."""
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def say(self, message: str, kind: types.MessageType = types.MessageType.Info) -> None:
        """Show one line to the person at the editor; more would hold up Neovim until a key is pressed."""
        self.window_show_message(types.ShowMessageParams(kind, " ".join(message.splitlines())))

    def start_io(self, stdin: Any = None, stdout: Any = None) -> None:
        """Serve over the standard streams. pygls reads each line on a thread of a pool, which every key would pay."""
        self.protocol.set_writer(StdoutWriter(sys.stdout.buffer))
        try:
            asyncio.run(self._serve())
        except (BrokenPipeError, KeyboardInterrupt, SystemExit):
            pass
        finally:
            self.shutdown()  # type: ignore[no-untyped-call]

    async def _serve(self) -> None:
        """Until the client's end, or its `exit`."""
        loop = asyncio.get_running_loop()
        frames = Frames()

        def take(data: bytes) -> None:
            try:
                bodies = list(frames.fed(data))
                given_up = frozenset(_given_up(bodies)) if len(bodies) > 1 else ()
                for body in bodies:
                    self.protocol.receive(body, given_up)
            except BrokenPipeError:  # nobody reads what we say any more
                data = b""
            if not data:
                self.ended.set()

        def read_what_is_there() -> None:
            data = os.read(0, READ_SIZE)
            if not data:
                loop.remove_reader(0)
            take(data)

        # Not through sys.stdin: its lock, held by a thread that waits, would keep Python from ending.
        def read_on_a_thread() -> None:
            while data := os.read(0, READ_SIZE):
                loop.call_soon_threadsafe(take, data)
            loop.call_soon_threadsafe(take, b"")

        try:
            loop.add_reader(0, read_what_is_there)  # a thread costs 44 µs more for each message
        except (NotImplementedError, OSError):  # on Windows; where standard input is a file
            threading.Thread(target=read_on_a_thread, daemon=True).start()
        await self.ended.wait()
        await self.close()


READ_SIZE = 65_536
_REFRESHES = {
    "code_lens": types.WORKSPACE_CODE_LENS_REFRESH,
    "diagnostics": types.WORKSPACE_DIAGNOSTIC_REFRESH,
    "inlay_hint": types.WORKSPACE_INLAY_HINT_REFRESH,
}
DOCUMENTS = {types.TEXT_DOCUMENT_DID_OPEN, types.TEXT_DOCUMENT_DID_CHANGE, types.TEXT_DOCUMENT_DID_CLOSE}
"""Ours alone: pygls keeps a copy of every text, and its way to edit it goes wrong after a form feed, after U+2028 and
at the end of a file."""


def _given_up(bodies: Sequence[bytes]) -> Iterator[int | str]:
    """The requests that these messages give up: who types on does so before the server has come to them."""
    for body in bodies:
        if b"cancelRequest" in body:
            with suppress(ValueError, LookupError, TypeError):  # what is no message is said where it is handled
                note = json.loads(body)
                if note["method"] == types.CANCEL_REQUEST:
                    yield note["params"]["id"]


class Protocol(LanguageServerProtocol):
    def receive(self, body: bytes, given_up: Collection[int | str] = ()) -> None:
        """Handle one message; those of documents at once, without what pygls does for requests and for threads.

        Requests whose ids are among those given up are refused.
        """
        try:
            message = self.structure_message(json.loads(body))
            if given_up and getattr(message, "id", None) in given_up and hasattr(message, "method"):
                error = JsonRpcRequestCancelled(f"request {message.id} was given up before it was begun")
                self._send_response(message.id, error=error.to_response_error())
            elif getattr(message, "method", None) in DOCUMENTS and not self._shutdown:
                self.fm.features[message.method](message.params)
            else:
                self.handle_message(message)
        except BrokenPipeError:
            raise
        except Exception as error:
            self._server.report_server_error(error, JsonRpcException)
