"""Messages out of a stream of bytes, LSP's base protocol, and everything that reaches into pygls's private parts.

Before each message stands a header with its length. Where a header is wrong, nobody knows where the next message
begins: the server ends, since one that no longer listens could not be told to stop the robots.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import sys
import threading
from collections.abc import Collection, Iterable, Iterator
from contextlib import suppress
from typing import Any

from lsprotocol import types
from pygls.exceptions import (
    JsonRpcException,
    JsonRpcInvalidParams,
    JsonRpcInvalidRequest,
    JsonRpcMethodNotFound,
    JsonRpcParseError,
    JsonRpcRequestCancelled,
    JsonRpcServerNotInitialized,
)
from pygls.io_ import StdoutWriter
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol

READ_SIZE = 65_536
LONGEST_HEADER = 65_536
_LENGTH = re.compile(rb"^content-length:[ \t]*(\d{1,9})[ \t]*\r?$", re.IGNORECASE | re.MULTILINE)
_HEADER_END = b"\r\n\r\n"
_HANDLED_AT_ONCE = {types.TEXT_DOCUMENT_DID_OPEN, types.TEXT_DOCUMENT_DID_CHANGE, types.TEXT_DOCUMENT_DID_CLOSE}
"""Not by pygls: it keeps a copy of every text, and edits it wrongly after a form feed, after U+2028 and at the end of a
file."""


class FramingError(Exception):
    """A header that does not say how long its message is."""


class Frames:
    """Cuts a stream of bytes into messages, keeping an incomplete one until the rest of it comes."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._length: int | None = None

    def feed(self, data: bytes) -> Iterator[bytes]:
        """The bodies that these bytes complete. Raises FramingError behind the last of them."""
        self._buffer += data
        while True:
            if self._length is None:
                end = self._buffer.find(_HEADER_END)
                if (end if end >= 0 else len(self._buffer)) > LONGEST_HEADER:
                    raise FramingError(f"no end of a header within {LONGEST_HEADER} bytes")
                if end < 0:
                    return
                length = _LENGTH.search(self._buffer, 0, end + 2)
                if not length:
                    raise FramingError("a header without a valid Content-Length")
                self._length = int(length[1])
                del self._buffer[: end + len(_HEADER_END)]
            if len(self._buffer) < self._length:
                return
            body = bytes(self._buffer[: self._length])
            del self._buffer[: self._length]
            self._length = None
            yield body


class StdioServer(LanguageServer):
    """A language server over standard input and output.

    pygls's own reads each line on a thread of a pool, at a cost that every key would pay.
    """

    protocol: Protocol

    def __init__(self, name: str, version: str) -> None:
        kind = types.TextDocumentSyncKind.Incremental
        super().__init__(name, version, text_document_sync_kind=kind, protocol_cls=Protocol)
        self._ended = asyncio.Event()

    def serve(self) -> int:
        """Serve until the editor ends. The exit code: 0 only if the editor has asked for the shutdown, as LSP wants."""
        self.protocol.set_writer(StdoutWriter(sys.stdout.buffer))
        try:
            asyncio.run(self._serve())
        except FramingError as error:
            print(f"improv-ls: cannot read the editor's messages: {error}", file=sys.stderr)
            return 1
        except (BrokenPipeError, KeyboardInterrupt):
            pass
        finally:
            self.shutdown()  # type: ignore[no-untyped-call]
        return 0 if self.protocol.closing else 1

    def end(self) -> None:
        """There is nobody left to serve."""
        self._ended.set()

    def withdraw(self, method: str) -> None:
        """Do not offer a method to this client. Only before `initialize` is answered."""
        self.protocol.fm.features.pop(method)

    async def close(self) -> None:
        """What is to be done before `shutdown` is answered, or before the end where nobody asks for a shutdown."""

    async def _serve(self) -> None:
        loop = asyncio.get_running_loop()
        frames = Frames()
        failure: FramingError | None = None

        def take(data: bytes) -> None:
            nonlocal failure
            bodies: list[bytes] = []
            try:
                bodies.extend(frames.feed(data))
            except FramingError as error:
                failure = error
            cancelled = frozenset(_cancelled(bodies)) if len(bodies) > 1 else ()
            try:
                for body in bodies:
                    if not self._ended.is_set():
                        self.protocol.receive(body, cancelled)
            except BrokenPipeError:  # nobody reads what we say
                self.end()
            if failure or not data:
                self.end()

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
        try:
            await self._ended.wait()
        finally:
            await (self.protocol.closing or self.close())
        if failure:
            raise failure


class Protocol(LanguageServerProtocol):
    """What pygls leaves open of the base protocol: the errors for what comes too early, too late or in a wrong form."""

    _server: StdioServer
    _initialized = False
    closing: asyncio.Task[None] | None = None
    """Once the client has asked for the shutdown."""

    def receive(self, body: bytes, cancelled: Collection[int | str] = ()) -> None:
        """Handle one message; a request whose id is among the cancelled ones is not begun."""
        try:
            data = json.loads(body)
        except (ValueError, RecursionError) as error:
            self._refuse(None, JsonRpcParseError.of(error))
            return
        if not isinstance(data, dict):
            self._refuse(None, JsonRpcInvalidRequest("a message must be one object"))
            return
        number = data.get("id")
        number = number if isinstance(number, int | str) else None
        try:
            if "method" in data:
                self._handle(data, number, cancelled)
            elif number is not None and ("result" in data or "error" in data):
                self._take_answer(data, number)
            elif "id" not in data:
                raise JsonRpcInvalidRequest("a message needs a method")
        except BrokenPipeError:
            raise
        except JsonRpcException as error:
            if "id" in data or "method" not in data:
                self._refuse(number, error)
        except Exception as error:
            self._server.report_server_error(error, JsonRpcException)

    def _handle(self, data: dict[str, Any], number: int | str | None, cancelled: Collection[int | str]) -> None:
        """Handle a request or notification. Raises JsonRpcException, which answers a request."""
        method = data["method"]
        if method == types.EXIT:
            self._server.end()
            return
        if data.get("jsonrpc") != self.VERSION or not isinstance(method, str) or ("id" in data and number is None):
            raise JsonRpcInvalidRequest
        if self.closing:
            raise JsonRpcInvalidRequest("the server is shutting down")
        if self._initialized == (method == types.INITIALIZE):
            raise JsonRpcInvalidRequest("initialized already") if self._initialized else JsonRpcServerNotInitialized
        if number is not None and number in cancelled:
            raise JsonRpcRequestCancelled
        if method not in self.fm.features and method not in self.fm.builtin_features and method != types.CANCEL_REQUEST:
            raise JsonRpcMethodNotFound.of(method)
        if method == types.SHUTDOWN:
            self.closing = asyncio.ensure_future(self._shut_down(number))
            return
        try:
            message = self.structure_message(data)
        except JsonRpcException as error:
            raise JsonRpcInvalidParams.of(f"{method}: {error.__cause__}") from error
        self._initialized = True
        if method in _HANDLED_AT_ONCE:
            self.fm.features[method](message.params)
        else:
            self.handle_message(message)

    def _take_answer(self, data: dict[str, Any], number: int | str) -> None:
        try:
            message = self.structure_message(data)
        except JsonRpcException as error:  # whoever waits for the answer has got none that could be used
            self._handle_response(number, error=error.to_response_error())
        else:
            self.handle_message(message)

    async def _shut_down(self, number: int | str | None) -> None:
        await self._server.close()
        if number is not None:
            self._send_response(number)

    def _refuse(self, number: int | str | None, error: JsonRpcException) -> None:
        self._send_data({"jsonrpc": self.VERSION, "id": number, "error": error.to_response_error()})


def _cancelled(bodies: Iterable[bytes]) -> Iterator[int | str]:
    """The ids of requests that these messages cancel: who types on does so before the server has come to them."""
    for body in bodies:
        if b"cancelRequest" in body:
            with suppress(ValueError, LookupError, TypeError, RecursionError):  # answered where it is handled
                note = json.loads(body)
                if note["method"] == types.CANCEL_REQUEST:
                    yield note["params"]["id"]
