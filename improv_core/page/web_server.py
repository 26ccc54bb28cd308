"""The parts that servers of pages share: the token, guards against other websites, and limits. They import aiohttp,
which takes long, so import them only when they are needed."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aiohttp import WSMsgType, web

from improv_core.ipc.rate_limit import Flood
from improv_core.page.connections import REST_LIMIT, Connections
from improv_core.page.files import CONTENT_TYPES, page_files
from improv_core.page.own_machine import OWN_HOST, user_of
from improv_core.protocol.tickets import Tickets

if TYPE_CHECKING:
    import socket

    from aiohttp.typedefs import Handler

HEADERS = {
    "Referrer-Policy": "no-referrer",  # the address holds a ticket
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


class Access:
    """The token that pages of a server send with every request, and the tickets that open a page with it."""

    def __init__(self, token: str, tickets: Tickets) -> None:
        self._token = token
        self._tickets = tickets

    def open(self, request: web.Request) -> str:
        """Return the token if the request has a valid ticket, otherwise "": after a reload, a page has its token."""
        ticket, transport = request.query.get("ticket"), request.transport
        if ticket is None or transport is None:
            return ""
        user = user_of(transport.get_extra_info("peername"), transport.get_extra_info("sockname"))
        return self._token if self._tickets.redeem(ticket, user) else ""

    def check(self, request: web.Request, *, needs_origin: bool = False) -> None:
        """Refuse a request without the token or of another website. Browsers send no origin when a page gets something
        from its own server, but always for a WebSocket and with what is posted."""
        own = f"http://{request.host}"
        is_own = request.headers.get("Origin", "" if needs_origin else own) == own
        if not is_own or not secrets.compare_digest(request.query.get("token", "").encode(), self._token.encode()):
            raise web.HTTPForbidden


@asynccontextmanager
async def serving(
    application: web.Application, listening: socket.socket, headers: Mapping[str, str], end_limit: float
) -> AsyncIterator[asyncio.Task[None]]:
    """Answer requests of this machine on a socket, for so long, with these headers. Yields the task that accepts
    connections. In the end, requests that are still being answered have `end_limit` seconds."""

    @web.middleware
    async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
        if not OWN_HOST.fullmatch(request.headers.get("Host", "")):
            raise web.HTTPForbidden
        with connections.keeping(request.protocol):
            return await handler(request)

    async def harden(request: web.Request, response: web.StreamResponse) -> None:
        response.headers.update(headers)

    application.middlewares.append(guard)
    application.on_response_prepare.append(harden)
    runner = runner_of(application, shutdown_timeout=end_limit)
    await runner.setup()
    assert runner.server is not None
    connections = Connections(runner.server)
    accepting = asyncio.create_task(connections.serve(listening))
    try:
        yield accepting
    finally:
        accepting.cancel()
        await runner.cleanup()


def runner_of(application: web.Application, **more: Any) -> web.AppRunner:
    """Return the runner of an application. It prints no requests, and no tracebacks of malformed ones."""
    logger = logging.getLogger("aiohttp.server")
    logger.addFilter(_is_of_server)  # adding it again changes nothing
    return web.AppRunner(
        application,
        access_log=None,
        logger=logger,
        keepalive_timeout=REST_LIMIT,
        auto_decompress=False,  # no page of ours compresses anything
        **more,
    )


def add_files(application: web.Application, folder: Path, within: str = "") -> None:
    """Serve the scripts and styles in a folder, or those whose paths there begin like this. All are read at once: no
    path ever comes from a URL."""
    files = {f"/{name}": path.read_bytes() for name, path in page_files(folder).items() if name.startswith(within)}

    async def show(request: web.Request) -> web.Response:
        content_type = CONTENT_TYPES[Path(request.path).suffix]
        return web.Response(body=files[request.path], content_type=content_type, charset="utf-8")

    for path in files:
        application.router.add_get(path, show)


async def receive(page: web.WebSocketResponse, request: web.Request, take: Callable[[str], None]) -> None:
    """Take the texts that a page sends, until it is closed or floods its server."""
    flood = Flood()
    async for message in page:
        if flood.counts(asyncio.get_running_loop().time()):
            abort(request)  # texts so far count; those that wait behind them are dropped
            return
        if message.type is WSMsgType.TEXT:
            take(message.data)


def abort(request: web.Request) -> None:
    """Cut the connection of a request."""
    if request.transport is not None:
        request.transport.abort()


def _is_of_server(record: logging.LogRecord) -> bool:
    problem = record.exc_info[1] if record.exc_info else None
    return type(problem).__module__ != "aiohttp.http_exceptions"
