"""The teacher's page and its WebSocket (aiohttp, imported lazily), on this machine's loopback address only."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Callable, Sequence
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core.classroom.connections import log
from improv_core.classroom.messages import Command, FromDesk, read
from improv_core.classroom.stop_reader import StopReader
from improv_core.ipc.rate_limit import Flood
from improv_core.page.connection_limit import SILENT_LIMIT, Connections
from improv_core.page.routes import CONTENT_TYPES, HOST, OWN_HOST
from improv_core.protocol.tickets import Tickets, issue

if TYPE_CHECKING:
    import socket

    from aiohttp import web
    from aiohttp.typedefs import Handler, Middleware

FOLDER = Path(__file__).parent / "static"
MOST_MESSAGE = 10_000
MOST_PAGES = 8
END_LIMIT = 0.05
"""Seconds that requests may take when the class ends. A page that is still open never finishes its own."""
CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


class TeacherPage:
    """Serves the page on a socket. `take` gets each command. `stop` stops everything at once, on any thread. `stage`
    makes a new address of the simulator's page, and `messages` returns the first messages for a page. `text` returns a
    child's dance, given the child's number and the number of dances it had sent."""

    def __init__(
        self,
        listening: socket.socket,
        take: Callable[[Command], None],
        stop: Callable[[], None],
        stage: Callable[[], str | None],
        messages: Callable[[], Sequence[FromDesk]],
        text: Callable[[int, int], str | None],
    ) -> None:
        self._socket = listening
        self._take, self._stage, self._messages = take, stage, messages
        self._text = text
        self._token = secrets.token_urlsafe()
        self._tickets = Tickets(self._token)
        self._queues: list[_PageQueue] = []
        port = listening.getsockname()[1]
        self._stops = StopReader(self._token, [f"http://{host}:{port}" for host in (HOST, "localhost")], stop)

    def link(self) -> str:
        """Return a new URL that opens the page once."""
        return f"http://{HOST}:{self._socket.getsockname()[1]}/?ticket={issue(self._token)}"

    def publish(self, message: FromDesk) -> None:
        """Send a message to all pages."""
        for queue in self._queues:
            queue.put(message)

    async def serve(self, address: str, code: str) -> None:
        """Serve the page, which shows the class's address and its code, until this is cancelled."""
        from aiohttp import web

        link, stops = f"{address}#class={code}", self._stops.origin
        page = (FOLDER / "teacher.html").read_text(encoding="utf-8")
        for mark, text in (("ADDRESS", address), ("ROOM_CODE", code), ("QR_CODE", _qr(link)), ("STOPS", stops)):
            page = page.replace(f"{{{mark}}}", escape(text))
        self._page = page
        application = web.Application(middlewares=[self._guard()])
        application.on_response_prepare.append(self._harden)
        application.router.add_get("/", self._show)
        application.router.add_get("/live", self._live)
        application.router.add_get("/stage", self._open_stage)
        application.router.add_get(r"/dance/{number:\d{1,9}}/{count:\d{1,9}}", self._show_dance)
        self._files = {f"/{path.name}": path for path in FOLDER.iterdir() if path.suffix in CONTENT_TYPES}
        for path in self._files:
            application.router.add_get(path, self._show_file)
        runner = web.AppRunner(
            application,
            access_log=None,
            logger=log(),
            shutdown_timeout=END_LIMIT,
            keepalive_timeout=SILENT_LIMIT,
            auto_decompress=False,  # no page of ours compresses anything
        )
        await runner.setup()
        assert runner.server is not None
        self._connections = Connections(runner.server)
        server = await asyncio.get_running_loop().create_server(self._connections.connect, sock=self._socket)
        try:
            await asyncio.Event().wait()
        finally:
            self._stops.close()
            server.close()
            await runner.cleanup()

    def _guard(self) -> Middleware:
        from aiohttp import web

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            if not OWN_HOST.fullmatch(request.headers.get("Host", "")):
                raise web.HTTPForbidden
            with self._connections.busy(request):
                return await handler(request)

        return guard

    async def _show(self, request: web.Request) -> web.Response:
        from aiohttp import web

        ticket = request.query.get("ticket")
        valid = ticket is not None and self._tickets.redeem(ticket, None)
        page = self._page.replace("{TOKEN}", escape(self._token) if valid else "")
        return web.Response(text=page, content_type="text/html", charset="utf-8")

    async def _show_file(self, request: web.Request) -> web.Response:
        from aiohttp import web

        path = self._files[request.path]
        return web.Response(body=path.read_bytes(), content_type=CONTENT_TYPES[path.suffix], charset="utf-8")

    async def _open_stage(self, request: web.Request) -> web.Response:
        from aiohttp import web

        self._check(request, needs_origin=False)
        if not (link := self._stage()):
            raise web.HTTPNotFound
        raise web.HTTPSeeOther(link)

    async def _show_dance(self, request: web.Request) -> web.Response:
        from aiohttp import web

        self._check(request, needs_origin=False)
        text = self._text(int(request.match_info["number"]), int(request.match_info["count"]))
        if text is None:
            raise web.HTTPNotFound
        return web.Response(text=text, content_type="text/plain", charset="utf-8")

    async def _live(self, request: web.Request) -> web.WebSocketResponse:
        from aiohttp import WSMsgType, web

        self._check(request)
        if len(self._queues) >= MOST_PAGES:
            raise web.HTTPServiceUnavailable
        page = web.WebSocketResponse(heartbeat=20, max_msg_size=MOST_MESSAGE, compress=False)
        await page.prepare(request)
        queue, flood = _PageQueue(), Flood()
        for each in self._messages():
            queue.put(each)
        self._queues.append(queue)
        telling = asyncio.create_task(queue.empty_into(page))
        try:
            async for message in page:
                if flood.counts(asyncio.get_running_loop().time()):
                    break
                if message.type is WSMsgType.TEXT and (command := read(message.data)):
                    self._take(command)
        finally:
            telling.cancel()
            self._queues.remove(queue)
        return page

    async def _harden(self, request: web.Request, response: web.StreamResponse) -> None:
        policy = CONTENT_POLICY.replace("connect-src 'self'", f"connect-src 'self' {self._stops.origin}")
        response.headers.update({**HEADERS, "Content-Security-Policy": policy})

    def _check(self, request: web.Request, *, needs_origin: bool = True) -> None:
        from aiohttp import web

        if not secrets.compare_digest(request.query.get("token", "").encode(), self._token.encode()):
            raise web.HTTPForbidden
        if needs_origin and request.headers.get("Origin") != f"http://{request.host}":
            raise web.HTTPForbidden


class _PageQueue:
    """The messages that wait for one page: of each child, only the latest."""

    def __init__(self) -> None:
        self._waiting: dict[str, FromDesk] = {}
        self._some = asyncio.Event()

    def put(self, message: FromDesk) -> None:
        about = str(message["number"]) if message["type"] in ("child", "gone") else message["type"]
        self._waiting.pop(about, None)
        self._waiting[about] = message
        self._some.set()

    async def empty_into(self, page: web.WebSocketResponse) -> None:
        with suppress(ConnectionError):
            while True:
                await self._some.wait()
                self._some.clear()
                waiting, self._waiting = self._waiting, {}
                for message in waiting.values():
                    await page.send_str(json.dumps(message))


def _qr(text: str) -> str:
    """A QR code as a URL of an image."""
    import segno

    return segno.make(text, error="m", micro=False).svg_data_uri(scale=4, border=2, light="white")
