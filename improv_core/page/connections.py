"""The connections of a server: how many there may be, and which ones are closed first."""

from __future__ import annotations

import asyncio
import math
import socket
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn, TypeVar

if TYPE_CHECKING:
    from aiohttp.web import Server
    from aiohttp.web_protocol import RequestHandler

MAX_PER_ADDRESS = 256
"""The most connections from one address: six for each of 40 browsers that share it, and a few more."""
MAX_CONNECTIONS = 2 * MAX_PER_ADDRESS
"""The most connections from all addresses: far fewer than the usual limit of 1024 open files."""
STALL_LIMIT = 20.0
"""Seconds without progress after which a connection is closed: no request arrives, a request stays incomplete, or the
browser doesn't read its answer."""
REST_LIMIT = 10.0
"""Seconds after its latest request in which a browser may send another one. Then aiohttp closes the connection."""
LOOK_PERIOD = 1.0
"""Seconds between two searches for stalled connections."""
AGAIN = 0.1
"""Seconds before the next try if no connection can be accepted."""

Key = TypeVar("Key")


@dataclass(frozen=True, slots=True)
class OpenConnection:
    """The address of a connection, and the time of its latest progress, in seconds; infinite while it must stay."""

    address: str
    moved: float


def to_close(connections: Mapping[Key, OpenConnection], address: str) -> Key | None:
    """Return the connection to close for a new one from this address; None if there is room, or all must stay.

    It belongs to this address if that has too many connections, and otherwise to the address with the most. Of that
    address, it is the connection without progress for longest.
    """
    counts = Counter(each.address for each in connections.values())
    if counts[address] >= MAX_PER_ADDRESS:
        crowd = address
    elif len(connections) >= MAX_CONNECTIONS:
        ((crowd, _),) = counts.most_common(1)
    else:
        return None
    oldest = min(
        (key for key in connections if connections[key].address == crowd), key=lambda key: connections[key].moved
    )
    return oldest if connections[oldest].moved < math.inf else None


def stalled(connections: Mapping[Key, OpenConnection], now: float) -> list[Key]:
    """The connections without progress for too long."""
    return [key for key, each in connections.items() if now - each.moved >= STALL_LIMIT]


class Connections:
    """The connections of a server. Its requests report their progress, or keep their connections."""

    def __init__(self, server: Server) -> None:
        self._server = server
        self._open: dict[RequestHandler, OpenConnection] = {}
        self._loop = asyncio.get_running_loop()

    async def serve(self, listening: socket.socket) -> NoReturn:
        """Accept connections until this is cancelled; then close the socket."""
        listening.setblocking(False)
        looking = asyncio.create_task(self._close_stalled())
        try:
            with listening:
                while True:
                    await self._accept(listening)
        finally:
            looking.cancel()

    def progressed(self, connection: RequestHandler) -> None:
        """Note that a request has arrived on a connection, or that its browser has read something."""
        self._note(connection, self._loop.time())

    @contextmanager
    def keeping(self, connection: RequestHandler) -> Iterator[None]:
        """Keep a connection while a request is answered; a page's WebSocket is one long request."""
        self._note(connection, math.inf)
        try:
            yield
        finally:
            self._note(connection, self._loop.time() + REST_LIMIT)

    def _note(self, connection: RequestHandler, moved: float) -> None:
        if known := self._open.get(connection):
            self._open[connection] = OpenConnection(known.address, moved)

    async def _accept(self, listening: socket.socket) -> None:
        try:
            accepted, (address, *_) = await self._loop.sock_accept(listening)
        except OSError:  # the system is out of file handles or memory for now
            await asyncio.sleep(AGAIN)
            return
        self._forget_closed()
        if replaced := to_close(self._open, address):
            _abort(replaced)
        with suppress(OSError):  # it is gone already
            _, connection = await self._loop.connect_accepted_socket(self._server, accepted)
            self._open[connection] = OpenConnection(address, self._loop.time())

    async def _close_stalled(self) -> None:
        while True:
            await asyncio.sleep(LOOK_PERIOD)
            self._forget_closed()
            for each in stalled(self._open, self._loop.time()):
                _abort(each)

    def _forget_closed(self) -> None:
        self._open = {
            each: progress
            for each, progress in self._open.items()
            if each.transport is not None and not each.transport.is_closing()
        }


def _abort(connection: RequestHandler) -> None:
    if isinstance(connection.transport, asyncio.Transport):
        connection.transport.abort()
