"""The teacher's stop, read on threads of its own. Whatever the event loop does, and even if the terminal takes no more
text, a stop goes straight to the stages' channels of stops."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Collection
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from secrets import compare_digest
from typing import Any
from urllib.parse import parse_qs, urlsplit

from improv_core.page.own_machine import HOST, OWN_HOST

LIMIT = 2.0
"""Seconds in which a request has to arrive."""
MOST = 16
"""The most requests that are read at the same time."""
AGAIN = 0.05
"""Seconds before the next try if the system has no file handle for a new connection."""


class StopReader:
    """Listens on a port of its own. Calls `stop`, on a thread, for a request from a page of one of these `origins` that
    has the token."""

    def __init__(self, token: str, origins: Collection[str], stop: Callable[[], None]) -> None:
        self.token, self.origins, self.stop = token.encode(), origins, stop
        self._listening = socket.create_server((HOST, 0))
        self._free = threading.BoundedSemaphore(MOST)
        self._closed = threading.Event()
        threading.Thread(target=self._serve, name="improv-stop-reader", daemon=True).start()

    @property
    def origin(self) -> str:
        """The address that pages use."""
        return f"http://{HOST}:{self._listening.getsockname()[1]}"

    def close(self) -> None:
        """Close the port."""
        self._closed.set()
        with suppress(OSError):
            self._listening.shutdown(socket.SHUT_RDWR)  # wakes the thread
        self._listening.close()

    def _serve(self) -> None:
        while not self._closed.is_set():
            try:
                asking, address = self._listening.accept()
            except OSError:  # closed; or the system is out of file handles for now
                self._closed.wait(AGAIN)
                continue
            if not self._free.acquire(blocking=False):
                asking.close()  # the page tries again
                continue
            threading.Thread(target=self._answer, args=(asking, address), daemon=True).start()

    def _answer(self, asking: socket.socket, address: object) -> None:
        try:
            with asking, suppress(OSError):
                _Request(asking, address, self)
        finally:
            self._free.release()


class _Request(BaseHTTPRequestHandler):
    """Answers one request."""

    timeout = LIMIT

    def __init__(self, asking: socket.socket, address: Any, reader: StopReader) -> None:
        self._reader = reader
        super().__init__(asking, address, reader)  # type: ignore[arg-type]

    def do_POST(self) -> None:
        origin = self.headers.get("Origin", "")
        token = parse_qs(urlsplit(self.path).query).get("token", [""])[0]
        allowed = origin in self._reader.origins and compare_digest(token.encode(), self._reader.token)
        if not allowed or not OWN_HOST.fullmatch(self.headers.get("Host", "")):
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        self._reader.stop()
        self.send_response(HTTPStatus.NO_CONTENT)
        self.send_header("Access-Control-Allow-Origin", origin)
        self.end_headers()

    def log_message(self, format: str, *values: object) -> None:
        """Print nothing."""
