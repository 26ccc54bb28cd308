"""The page over HTTP and its WebSocket (aiohttp, imported lazily), and the guards against other websites."""

from __future__ import annotations

import asyncio
import re
import secrets
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core.stage.protocol import PageRequest, Watched
from improv_core.stage.viewer.requests import read

if TYPE_CHECKING:
    import socket

    from aiohttp import web
    from aiohttp.typedefs import Handler, Middleware

    from improv_core.stage.viewer.answers import Answers
    from improv_core.stage.viewer.outbox import Outbox
    from improv_core.stage.viewer.pages import Pages

HOST = "127.0.0.1"
OWN_HOST = re.compile(r"(127\.0\.0\.1|localhost):\d+")
PARTING = 0.25
"""Seconds that pages have at the end to receive the reason."""
MAX_PAGES = 64
MAX_MESSAGE = 256 * 1024
"""Bytes of a message from a page: enough to silence every robot by name."""
WATCHED: Watched = {"type": "watched"}
FOLDER = Path(__file__).parent / "page"
CONTENT_TYPES = {".css": "text/css", ".js": "text/javascript"}

_LOOPBACK = " ".join(f"{scheme}://{name}:*" for scheme in ("http", "https") for name in (HOST, "localhost"))
HEADERS = {
    # Editors show the page in a frame: VS Code on a desktop from schemes of its own, in a browser from this machine and
    # with webviews from its CDN. Every frame around the page has to be among these.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'none'; "
    f"frame-ancestors {_LOOPBACK} vscode-webview: vscode-file: https://*.vscode-cdn.net",
    "Referrer-Policy": "no-referrer",  # the address holds the token
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


class Application:
    """Serves the page on a socket to anybody who has the token.

    `command` gets each command from a page, and `WATCHED` when one is opened.
    """

    def __init__(
        self, token: str, pages: Pages, answers: Answers, command: Callable[[PageRequest | Watched], None]
    ) -> None:
        self._token = token
        self._pages = pages
        self._answers = answers
        self._command = command
        self._open: dict[Outbox, web.Request] = {}
        self._index = (FOLDER / "index.html").read_bytes()
        self._files = _files()

    async def serve(self, listening: socket.socket, stop: asyncio.Event) -> None:
        """Serve until `stop` is set; then pages get what still waits for them, and are disconnected."""
        from aiohttp import web

        runner = web.AppRunner(self._application(), access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        await web.SockSite(runner, listening).start()
        await stop.wait()
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._pages.emptied(), PARTING)
        for request in self._open.values():
            if request.transport is not None:
                request.transport.abort()  # closing politely would wait for pages that no longer listen
        await runner.cleanup()

    def _application(self) -> web.Application:
        from aiohttp import web

        application = web.Application(middlewares=[_guard()])
        application.on_response_prepare.append(_harden)
        application.router.add_get("/", self._show_page)
        application.router.add_get("/path.svg", self._show_path)
        application.router.add_get("/live", self._live)
        for path in self._files:
            application.router.add_get(path, self._show_file)
        return application

    async def _show_page(self, request: web.Request) -> web.Response:
        from aiohttp import web

        self._check_token(request)
        return web.Response(body=self._index, content_type="text/html", charset="utf-8")

    async def _show_file(self, request: web.Request) -> web.Response:
        from aiohttp import web

        content_type = CONTENT_TYPES[Path(request.path).suffix]
        return web.Response(body=self._files[request.path], content_type=content_type, charset="utf-8")

    async def _show_path(self, request: web.Request) -> web.Response:
        from aiohttp import web

        self._check_token(request)
        if "Origin" in request.headers:  # browsers omit it when a page asks its own server
            _check_origin(request)
        picture = await self._answers.compute(self._answers.picture)
        if picture is None:
            raise web.HTTPNotFound
        return web.Response(text=picture, content_type="image/svg+xml")

    async def _live(self, request: web.Request) -> web.WebSocketResponse:
        from aiohttp import WSMsgType, web

        self._check_token(request)
        _check_origin(request)
        if len(self._pages) >= MAX_PAGES:
            raise web.HTTPServiceUnavailable
        # Nothing is buffered beyond what the system takes, so that a slow page sees the present.
        page = web.WebSocketResponse(heartbeat=20, compress=False, max_msg_size=MAX_MESSAGE, writer_limit=0)
        outbox = self._pages.join()
        self._open[outbox] = request
        tasks: list[asyncio.Task[None]] = []
        try:
            await page.prepare(request)
            tasks = [asyncio.create_task(outbox.empty_into(page)), asyncio.create_task(self._answer(outbox))]
            self._command(WATCHED)
            async for message in page:
                if message.type is WSMsgType.TEXT:
                    self._receive(message.data, outbox)
        finally:
            for task in tasks:
                task.cancel()
            del self._open[outbox]
            self._pages.leave(outbox)
        return page

    def _receive(self, text: str, outbox: Outbox) -> None:
        request = read(text)
        if request is None:
            return
        if request["type"] == "window":
            outbox.ask(request)
        else:
            self._command(request)

    async def _answer(self, outbox: Outbox) -> None:
        """Answer the latest question of a page, forever."""
        while True:
            question = await outbox.asked()
            text = await self._answers.compute(partial(self._answers.window, question))
            if text is not None:
                outbox.put("window", text)

    def _check_token(self, request: web.Request) -> None:
        from aiohttp import web

        if not secrets.compare_digest(request.query.get("token", "").encode(), self._token.encode()):
            raise web.HTTPForbidden(text="Open the page with the address that Improv printed.")


def _files() -> Mapping[str, bytes]:
    """The page's files by path, read once: no path ever comes from a URL."""
    return {f"/{path.name}": path.read_bytes() for path in FOLDER.iterdir() if path.suffix in CONTENT_TYPES}


def _guard() -> Middleware:
    from aiohttp import web

    @web.middleware
    async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
        # Another website may point a name of its own at this machine, so only this machine's names are answered. The
        # port may differ: an editor brings the page to its window through a tunnel.
        if not OWN_HOST.fullmatch(request.headers.get("Host", "")):
            raise web.HTTPForbidden
        return await handler(request)

    return guard


async def _harden(request: web.Request, response: web.StreamResponse) -> None:
    response.headers.update(HEADERS)


def _check_origin(request: web.Request) -> None:
    from aiohttp import web

    if request.headers.get("Origin") != f"http://{request.host}":
        raise web.HTTPForbidden
