"""LSP's base protocol, and all uses of pygls's private parts."""

from __future__ import annotations

import asyncio
import json
import sys
import threading
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from typing import Any, BinaryIO

from cattrs import Converter
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
from pygls.protocol import LanguageServerProtocol, default_converter

from improv_core.safety.stops import Stops
from improv_core.slices import checkpoint
from improv_ls.arrivals import Arrival, Arrivals, FramingError
from improv_ls.positions import range_of

_HANDLED_AT_ONCE = {
    *(types.TEXT_DOCUMENT_DID_OPEN, types.TEXT_DOCUMENT_DID_CHANGE, types.TEXT_DOCUMENT_DID_CLOSE),
    *(types.TEXT_DOCUMENT_WILL_SAVE, types.TEXT_DOCUMENT_DID_SAVE),
}
"""Methods that pygls doesn't handle: it keeps a copy of every text, and edits it wrongly after a form feed, after
U+2028, and at the end of a file; and robots would wait for it."""

MAX_ITEMS = 1_000
"""The most items of a list whose JSON is made at once."""


class StdioServer(LanguageServer):
    """A language server that reads a file descriptor, usually standard input.

    The server of pygls reads each line on a thread of a pool, which every key would pay for.
    """

    protocol: Protocol

    def __init__(self, name: str, version: str) -> None:
        kind = types.TextDocumentSyncKind.Incremental
        super().__init__(
            name, version, text_document_sync_kind=kind, protocol_cls=Protocol, converter_factory=converter
        )
        self._ended = asyncio.Event()
        self.stops = Stops()
        self.arrival = Arrival(b"", 0, False)
        """The message that is being handled."""
        self._loop_reads = False
        self.sliced: set[str] = set()
        """Requests that may take long and change nothing."""

    def serve(self, source: int, sink: BinaryIO) -> int:
        """Serve until the editor ends. Returns exit code 0 only if the editor has asked for that, as LSP wants."""
        self._arrivals = Arrivals(self.stops, source)
        self.protocol.set_writer(StdoutWriter(sink))
        try:
            asyncio.run(self._serve(source))
        except FramingError as error:
            print(f"improv-ls: cannot read the editor's messages: {error}", file=sys.stderr)
            return 1
        except (BrokenPipeError, KeyboardInterrupt):
            pass
        finally:
            self.shutdown()  # type: ignore[no-untyped-call]
        return 0 if self.protocol.closing else 1

    def end(self) -> None:
        """End the server, because it has no client anymore."""
        self._ended.set()

    def withdraw(self, method: str) -> None:
        """Withhold a method from this client. Only before `initialize` is answered."""
        self.protocol.fm.features.pop(method)

    def answer(self, method: str, function: Callable[[], Any], params: Any, future: Future[Any]) -> None:
        """Answer one of the `sliced` requests, now or later, with the result of a function."""
        raise NotImplementedError

    async def close(self) -> None:
        """Close everything before `shutdown` is answered, or before the end if the client requests no shutdown."""

    def obey_while_busy(self) -> None:
        """Obey stops from now on even while the event loop is busy."""
        if self._loop_reads:  # otherwise, a thread already does
            tell = partial(asyncio.get_running_loop().call_soon_threadsafe, self._handle)
            threading.Thread(target=self._arrivals.read_while_busy, args=(tell,), daemon=True).start()

    async def _serve(self, source: int) -> None:
        loop = asyncio.get_running_loop()

        def read_and_handle() -> None:
            self._arrivals.read()
            if self._arrivals.ended:
                loop.remove_reader(source)
            self._handle()

        # Not through sys.stdin: its lock, held by a thread that waits, would keep Python from ending.
        def read_on_a_thread() -> None:
            while not self._arrivals.ended:
                self._arrivals.read()
                loop.call_soon_threadsafe(self._handle)

        try:
            loop.add_reader(source, read_and_handle)
        except (NotImplementedError, OSError):  # on Windows; where standard input is a file
            threading.Thread(target=read_on_a_thread, daemon=True).start()
        else:
            self._loop_reads = True
        try:
            await self._ended.wait()
        finally:
            await (self.protocol.closing or self.close())
        if self._arrivals.failure:
            raise self._arrivals.failure

    def _handle(self) -> None:
        """Handle the messages that have arrived."""
        arrivals = list(self._arrivals.take())
        cancelled = frozenset(_cancelled(arrivals)) if len(arrivals) > 1 else ()
        try:
            for each in arrivals:
                if each is None:
                    self.end()
                elif not self._ended.is_set():
                    self.protocol.receive(each, cancelled)
        except BrokenPipeError:  # nobody reads our messages
            self.end()


class Protocol(LanguageServerProtocol):
    """Base protocol with the errors that pygls lacks: for messages that are too early, too late, or malformed."""

    _server: StdioServer
    _initialized = False
    closing: asyncio.Task[None] | None = None
    """Set once the client has asked for a shutdown."""

    def receive(self, arrival: Arrival, cancelled: Collection[int | str] = ()) -> None:
        """Handle one message; a request whose ID is among the canceled ones does not start."""
        self._server.arrival = arrival
        try:
            data = json.loads(arrival.body)
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
        if method == types.TEXT_DOCUMENT_DID_CHANGE and (change := _usual_change(data.get("params"))):
            self.fm.features[method](change)
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

    def notify(self, method: str, params: Any | None = None) -> None:
        """Send a notification. pygls would validate it again."""
        self._send_data({"jsonrpc": self.VERSION, "method": method, **({} if params is None else {"params": params})})

    def _send_data(self, data: Any) -> None:
        self._write(json.dumps(data, default=self._serialize_message))

    def _write(self, body: str) -> None:
        if self.writer:
            self.writer.write(f"Content-Length: {len(body)}\r\n\r\n{body}".encode())

    def _handle_request(self, msg_id: int | str, method_name: str, params: Any) -> None:
        if method_name not in self._server.sliced:
            super()._handle_request(msg_id, method_name, params)
            return
        future: Future[Any] = Future()
        self._request_futures[msg_id] = future
        future.add_done_callback(partial(self._answer, msg_id))
        self._server.answer(method_name, partial(self._result, self._get_handler(method_name), params), params, future)

    def _result(self, handler: Callable[[Any], Any], params: Any) -> str:
        """Return the result of a handler as JSON. A long list can be interrupted between its items."""
        result = handler(params)
        if not isinstance(result, list):
            return "".join(_json(self._converter.unstructure(result)))
        items = []
        for item in result:
            checkpoint()
            items.append(json.dumps(self._converter.unstructure(item)))
        return f"[{', '.join(items)}]"

    def _answer(self, number: int | str, future: Future[Any]) -> None:
        if future.cancelled() or future.exception():
            self._send_handler_result(future, msg_id=number)
            return
        self._request_futures.pop(number, None)
        self._result_types.pop(number, None)
        self._write(f'{{"jsonrpc": "{self.VERSION}", "id": {json.dumps(number)}, "result": {future.result()}}}')

    def _take_answer(self, data: dict[str, Any], number: int | str) -> None:
        try:
            message = self.structure_message(data)
        except JsonRpcException as error:  # the code that waits for the answer can't use it
            self._handle_response(number, error=error.to_response_error())
        else:
            self.handle_message(message)

    async def _shut_down(self, number: int | str | None) -> None:
        await self._server.close()
        if number is not None:
            self._send_response(number)

    def _refuse(self, number: int | str | None, error: JsonRpcException) -> None:
        self._send_data({"jsonrpc": self.VERSION, "id": number, "error": error.to_response_error()})


def converter() -> Converter:
    """Return a converter of LSP's types, for diagnostics that are JSON already (`to_lsp.diagnostic`)."""
    made: Converter = default_converter()  # type: ignore[no-untyped-call]

    def json_of(diagnostic: Any) -> Any:  # in an action to resolve, it is as the client has sent it
        return diagnostic if isinstance(diagnostic, dict) else default_converter().unstructure(diagnostic)  # type: ignore[no-untyped-call]

    made.register_unstructure_hook(types.Diagnostic, json_of)
    return made


def _json(value: object) -> Iterator[str]:
    """Yield the parts of JSON. The colors of a long line are a list of a million numbers, so it is made in slices."""
    if isinstance(value, dict):
        yield "{"
        for place, (key, each) in enumerate(value.items()):
            yield f"{', ' if place else ''}{json.dumps(key)}: "
            yield from _json(each)
        yield "}"
    elif isinstance(value, list) and len(value) > MAX_ITEMS:
        for start in range(0, len(value), MAX_ITEMS):
            checkpoint()
            yield f"{', ' if start else '['}{json.dumps(value[start : start + MAX_ITEMS])[1:-1]}"
        yield "]"
    else:
        yield json.dumps(value)


def _usual_change(params: Any) -> types.DidChangeTextDocumentParams | None:
    """Read the change that a key makes, in a third of the time that the converter takes; None for any other change, or
    a malformed one."""
    try:
        document, (change,) = params["textDocument"], params["contentChanges"]
        uri, version, range_, text = document["uri"], document["version"], range_of(change["range"]), change["text"]
        if not range_ or type(uri) is not str or type(text) is not str:
            return None
        changes = [types.TextDocumentContentChangePartial(range_, text)]
        return types.DidChangeTextDocumentParams(types.VersionedTextDocumentIdentifier(version, uri), changes)
    except (LookupError, TypeError, ValueError):
        return None


def _cancelled(arrivals: Iterable[Arrival | None]) -> Iterator[int | str]:
    """Yield the IDs of requests that these messages cancel: further typing cancels them before they start."""
    for each in arrivals:
        if each and b"cancelRequest" in each.body:
            with suppress(ValueError, LookupError, TypeError, RecursionError):  # the message's handler answers it
                note = json.loads(each.body)
                if note["method"] == types.CANCEL_REQUEST:
                    yield note["params"]["id"]
