"""The page over HTTP and its WebSocket (aiohttp, imported lazily), and the guards against other websites."""

from __future__ import annotations

import asyncio
import re
import secrets
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core.ipc.rate_limit import Flood, Throttle
from improv_core.page.connection import PageConnection
from improv_core.page.connection_limit import SILENT_LIMIT, Connections
from improv_core.page.peer_user import user_of
from improv_core.page.song_file import serve
from improv_core.page.stop_confirmations import PageStops
from improv_core.protocol.commands import PageRequest, Watched
from improv_core.protocol.page_requests import read_count, read_page
from improv_core.protocol.tickets import Tickets
from improv_core.safety.stage_stops import stop_stages

if TYPE_CHECKING:
    import socket

    from aiohttp import web
    from aiohttp.typedefs import Handler, Middleware

    from improv_core.page.answers import Answers
    from improv_core.page.open_pages import Pages
    from improv_core.page.outbox import PageOutbox
    from improv_core.score.music import Music

HOST = "127.0.0.1"
OWN_HOST = re.compile(r"(127\.0\.0\.1|localhost):\d+")
PARTING = 0.25
"""Seconds that pages have at the end to receive the reason."""
MAX_PAGES = 64
MAX_MESSAGE = 1024 * 1024
"""Bytes of a message from a page: enough for the longest text, in any JSON encoding."""
CONFIRM_LIMIT = 1.0
"""Seconds for which a stop may wait for its confirmation. Then the page learns that the stop has only arrived."""
ASK_LIMIT = 0.8
"""Seconds for which stages may let a stop wait for their own confirmation: less, so that the answer has their names."""
MOST_ASKING = 16
"""The most stops whose confirmation by stages is awaited at the same time."""
FOLDER = Path(__file__).parent / "static"
NO_TOKEN = '<meta id="token" name="improv-token" content="">'
"""The tag in index.html that the token replaces."""
CONTENT_TYPES = {".css": "text/css", ".js": "text/javascript"}

# Only VS Code shows the page in a frame. Every frame around the page has to be among these. On a desktop, these are the
# window (vscode-file:) and the webview (vscode-webview:). In a browser, it is code-server or `code serve-web` on this
# machine, on any port, and webviews from VS Code's CDN, where each has its own host. Any other server on this machine
# may frame the page, too, but without a ticket: then the page has no token, because in a frame it uses only a token
# from a ticket that this very load has redeemed.
FRAMES = f"http://{HOST}:* http://localhost:* vscode-file: vscode-webview: https://*.vscode-cdn.net"
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'none'; "
    f"frame-ancestors {FRAMES}",
    "Referrer-Policy": "no-referrer",  # the address holds a ticket
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


class Application:
    """Serves the page on a socket: with the token if the URL has a valid ticket. Every request except for the page's
    files needs the token.

    `command` gets each command from a page, and `watched` when a page is opened, or closed in a frame. `music` returns
    the song that plays. A stop also goes straight to the stages of the `show`, if their sockets are known.
    """

    def __init__(
        self,
        token: str,
        pages: Pages,
        answers: Answers,
        command: Callable[[PageRequest | Watched], None],
        music: Callable[[], Music | None],
        show: Path | None = None,
    ) -> None:
        self._show = show
        self._asking = 0  # the number of stops whose confirmation by stages is awaited
        self._token = token
        self._tickets = Tickets(token)
        self._pages = pages
        self._answers = answers
        self._command = command
        self._music = music
        self._throttle = Throttle(command, lambda delay, do: asyncio.get_running_loop().call_later(delay, do))
        self._stops = PageStops()
        self._confirmed = asyncio.Event()  # set, and replaced, whenever a stop was confirmed
        self._open: dict[PageOutbox, web.Request] = {}
        self._framed = 0  # the number of these in a frame
        self._index = (FOLDER / "index.html").read_text(encoding="utf-8")
        assert self._index.count(NO_TOKEN) == 1
        self._files = _files()

    def confirm(self, mark: str, waits_for: Sequence[str] = ()) -> None:
        """Note that the stop with this mark has been obeyed, or the stages that have yet to obey it, to inform its
        page."""
        page, _, number = mark.rpartition(" ")
        if waits_for:
            self._stops.wait(page, int(number), ", ".join(waits_for))
            return
        self._stops.confirm(page, int(number))
        self._confirmed.set()
        self._confirmed = asyncio.Event()

    async def serve(self, listening: socket.socket, stop: asyncio.Event) -> None:
        """Serve until `stop` is set. Then send the messages that wait for pages, and disconnect the pages."""
        await _visited(listening, stop)
        if stop.is_set():
            listening.close()
            return
        from aiohttp import web  # only now: that takes long, and robots must not wait for it

        runner = web.AppRunner(
            self._application(), access_log=None, shutdown_timeout=1.0, keepalive_timeout=SILENT_LIMIT
        )
        await runner.setup()
        assert runner.server is not None
        self._connections = Connections(runner.server)
        server = await asyncio.get_running_loop().create_server(self._connections.connect, sock=listening)
        await stop.wait()
        server.close()
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._pages.emptied(), PARTING)
        for request in self._open.values():
            _abort(request)  # closing politely would wait for pages that no longer listen
        await runner.cleanup()

    def _application(self) -> web.Application:
        from aiohttp import web

        application = web.Application(middlewares=[self._guard()])
        application.on_response_prepare.append(_harden)
        application.router.add_get("/", self._show_page)
        application.router.add_get("/token", self._accept_token)
        application.router.add_get("/path.svg", self._show_path)
        application.router.add_get("/song", self._play_song)
        application.router.add_get("/time", self._tell_time)
        application.router.add_get("/live", self._live)
        application.router.add_post("/stop", self._stop)
        for path in self._files:
            application.router.add_get(path, self._show_file)
        return application

    def _guard(self) -> Middleware:
        from aiohttp import web

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            # Another website may point a name of its own at this machine, so only this machine's names are answered.
            # The port may differ: an editor brings the page to its window through a tunnel.
            if not OWN_HOST.fullmatch(request.headers.get("Host", "")):
                raise web.HTTPForbidden
            with self._connections.busy(request):
                return await handler(request)

        return guard

    async def _show_page(self, request: web.Request) -> web.Response:
        """Serve the page: with the token for a valid ticket, else without it, as after a reload."""
        from aiohttp import web

        ticket = request.query.get("ticket")
        valid = ticket is not None and self._tickets.redeem(ticket, _user_of(request))
        given = NO_TOKEN.replace('""', f'"{escape(self._token)}"') if valid else NO_TOKEN
        page = self._index.replace(NO_TOKEN, given)
        return web.Response(text=page, content_type="text/html", charset="utf-8")

    async def _show_file(self, request: web.Request) -> web.Response:
        from aiohttp import web

        content_type = CONTENT_TYPES[Path(request.path).suffix]
        return web.Response(body=self._files[request.path], content_type=content_type, charset="utf-8")

    async def _accept_token(self, request: web.Request) -> web.Response:
        """Check the page's token, because browsers hide from a page why its WebSocket was refused."""
        from aiohttp import web

        self._check_token(request)
        return web.Response(status=204)

    async def _show_path(self, request: web.Request) -> web.Response:
        from aiohttp import web

        self._check_own(request)
        picture = await self._answers.compute(self._answers.picture)
        if picture is None:
            raise web.HTTPNotFound
        return web.Response(text=picture, content_type="image/svg+xml")

    async def _play_song(self, request: web.Request) -> web.StreamResponse:
        self._check_own(request)
        return await serve(request, self._music())

    async def _tell_time(self, request: web.Request) -> web.Response:
        """Return the server's Unix time, for a page that needs it more exactly than its first message gave it."""
        from aiohttp import web

        self._check_own(request)
        return web.Response(text=repr(time.time()))

    async def _stop(self, request: web.Request) -> web.Response:
        """Take a stop over its own connection: 204 once all have obeyed it, else 202 with the names of the others, if
        known."""
        from aiohttp import web

        self._check_token(request)
        _check_origin(request)
        page, number = read_page(request.query.get("page")), read_count(request.query.get("number"))
        if not page or number is None:
            raise web.HTTPBadRequest
        if self._stops.arrive(page, number):
            self._pass_stop(page, number)
        elif not self._stops.is_confirmed(page, number):
            self._ask_stages(page, number)  # another one may have taken over the robots of one that has died
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._is_confirmed(page, number), CONFIRM_LIMIT)
        if self._stops.is_confirmed(page, number):
            return web.Response(status=204)
        return web.Response(status=202, text=self._stops.waits_for(page))

    async def _is_confirmed(self, page: str, number: int) -> None:
        while not self._stops.is_confirmed(page, number):
            await self._confirmed.wait()

    def _pass_stop(self, page: str, number: int) -> None:
        self._ask_stages(page, number)
        self._throttle.take({"type": "stop", "mark": f"{page} {number}"})

    def _ask_stages(self, page: str, number: int) -> None:
        """Send a stop straight to all stages, on a thread: one that is halted must not delay the next stop."""
        if self._show is None or self._asking >= MOST_ASKING:
            return
        loop, show, mark = asyncio.get_running_loop(), self._show, f"{page} {number}"

        def ask() -> None:
            waits_for = stop_stages(show, {"type": "stop", "direct": mark}, ASK_LIMIT)
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(heard, waits_for)

        def heard(waits_for: Sequence[str] | None) -> None:
            self._asking -= 1
            if waits_for is not None:
                self.confirm(mark, waits_for)

        with suppress(RuntimeError):  # there can't be more threads now: the parent gets the stop anyway
            threading.Thread(target=ask, daemon=True).start()
            self._asking += 1

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
        name, framed, flood = read_page(request.query.get("page")), "framed" in request.query, Flood()
        self._framed += framed
        stop = partial(self._pass_stop, name)
        connection = PageConnection(name, outbox, self._answers, self._stops, stop, self._throttle.take)
        sending: asyncio.Task[None] | None = None
        try:
            await page.prepare(request)
            sending = asyncio.create_task(connection.send_to(page))
            self._command(self._watched(framed))
            async for message in page:
                if flood.counts(asyncio.get_running_loop().time()):
                    _abort(request)  # requests sent so far count; those that wait behind them are dropped
                    break
                if message.type is WSMsgType.TEXT:
                    connection.receive(message.data)
        finally:
            if sending:
                sending.cancel()
            del self._open[outbox]
            self._pages.leave(outbox)
            self._framed -= framed
            if framed:
                self._command(self._watched(framed))
        return page

    def _watched(self, framed: bool) -> Watched:
        return {"type": "watched", "framed": self._framed} if framed else {"type": "watched"}

    def _check_own(self, request: web.Request) -> None:
        self._check_token(request)
        if "Origin" in request.headers:  # browsers omit it when a page asks its own server
            _check_origin(request)

    def _check_token(self, request: web.Request) -> None:
        from aiohttp import web

        if not secrets.compare_digest(request.query.get("token", "").encode(), self._token.encode()):
            raise web.HTTPForbidden


async def _visited(listening: socket.socket, stop: asyncio.Event) -> None:
    """Wait until somebody connects, or until `stop` is set."""
    loop, visited = asyncio.get_running_loop(), asyncio.Event()
    try:
        loop.add_reader(listening, visited.set)
    except NotImplementedError:  # on Windows
        return
    waiting = [asyncio.create_task(event.wait()) for event in (visited, stop)]
    await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
    loop.remove_reader(listening)
    for task in waiting:
        task.cancel()


def _files() -> Mapping[str, bytes]:
    """The page's files by path, read once: no path ever comes from a URL."""
    return {f"/{name}": path.read_bytes() for name, path in page_files().items()}


def page_files() -> Mapping[str, Path]:
    """Return the page's files by their paths below its folder."""
    found = sorted(path for path in FOLDER.rglob("*") if path.suffix in CONTENT_TYPES)
    return {path.relative_to(FOLDER).as_posix(): path for path in found}


async def _harden(request: web.Request, response: web.StreamResponse) -> None:
    response.headers.update(HEADERS)


def _abort(request: web.Request) -> None:
    if request.transport is not None:
        request.transport.abort()


def _user_of(request: web.Request) -> int | None:
    transport = request.transport
    return user_of(transport.get_extra_info("peername"), transport.get_extra_info("sockname")) if transport else None


def _check_origin(request: web.Request) -> None:
    from aiohttp import web

    if request.headers.get("Origin") != f"http://{request.host}":
        raise web.HTTPForbidden
