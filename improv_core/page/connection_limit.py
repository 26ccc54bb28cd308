"""Bounds the connections to the page's server, so that nobody can use up the file handles of the process."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aiohttp.web import Request, Server
    from aiohttp.web_protocol import RequestHandler

SILENT_LIMIT = 10.0
"""Seconds after which a connection without a first request is closed. Later, the server's own limit holds, which counts
from the latest request. Otherwise, a request that is just arriving would be lost."""
MAX_CONNECTIONS = 256
"""More than all pages and their files need, and far fewer than the usual limit of 1024 open files."""


class Connections:
    """The connections of a server. If there are too many, a new one replaces the oldest one that has no request."""

    def __init__(self, server: Server) -> None:
        self._server = server
        self._busy: set[RequestHandler] = set()
        self._silent: dict[RequestHandler, asyncio.TimerHandle] = {}

    def connect(self) -> asyncio.BaseProtocol:
        """Return the protocol that handles a new connection."""
        idle = [each for each in self._server.connections if self._is_idle(each)]
        if len(idle) + len(self._busy) >= MAX_CONNECTIONS and idle:
            _abort(idle[0])
        connection = self._server()
        later = asyncio.get_running_loop().call_later(SILENT_LIMIT, self._close_silent, connection)
        self._silent[connection] = later
        return connection

    @contextmanager
    def busy(self, request: Request) -> Iterator[None]:
        """Keep the connection open while a request is answered; a page's WebSocket is one long request."""
        self._busy.add(request.protocol)
        if later := self._silent.pop(request.protocol, None):
            later.cancel()
        try:
            yield
        finally:
            self._busy.discard(request.protocol)

    def _is_idle(self, connection: RequestHandler) -> bool:
        closing = connection.transport is None or connection.transport.is_closing()
        return not closing and connection not in self._busy

    def _close_silent(self, connection: RequestHandler) -> None:
        del self._silent[connection]
        if self._is_idle(connection):
            _abort(connection)


def _abort(connection: RequestHandler) -> None:
    assert isinstance(connection.transport, asyncio.Transport)
    connection.transport.abort()
