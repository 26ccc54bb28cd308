"""Serves the page and keeps it up to date over a WebSocket, from a thread of its own (aiohttp, imported lazily)."""

from __future__ import annotations

import asyncio
import json
import queue
import secrets
import socket
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from improv_core.score import Score
from improv_core.stage.window import about, window

if TYPE_CHECKING:
    from aiohttp import web
    from aiohttp.typedefs import Handler

    from improv_core.stage.sinks.simulator import Snapshot

HOST = "127.0.0.1"
FRAME = 1 / 60
MAX_PAGES = 64
MAX_MESSAGE = 256 * 1024
"""Bytes of a message from a page: enough to silence every robot by its name."""
MOST_NAMES, LONGEST_NAME = 1000, 100
LAST_BEAT = 1e15
"""Where beats stop being exact as numbers of JavaScript."""
MOST_BEATS = 256
"""In one window."""
WINDOWS_KEPT = 64
"""Windows told to one page that the next may ask for."""
WATCHED = {"type": "watched"}
FILES = {
    "/page.css": "text/css",
    "/panels.css": "text/css",
    "/anchor.js": "text/javascript",
    "/camera.js": "text/javascript",
    "/clock.js": "text/javascript",
    "/colors.js": "text/javascript",
    "/connection.js": "text/javascript",
    "/controls.js": "text/javascript",
    "/ground.js": "text/javascript",
    "/hands.js": "text/javascript",
    "/items.js": "text/javascript",
    "/keys.js": "text/javascript",
    "/messages.js": "text/javascript",
    "/motion.js": "text/javascript",
    "/outlook.js": "text/javascript",
    "/page.js": "text/javascript",
    "/panels.js": "text/javascript",
    "/path.js": "text/javascript",
    "/robots.js": "text/javascript",
    "/score.js": "text/javascript",
    "/stage.js": "text/javascript",
    "/starts.js": "text/javascript",
    "/takeaway.js": "text/javascript",
    "/timeline.js": "text/javascript",
    "/timesheet.js": "text/javascript",
}
"""The files a page asks for, and their content types. Nothing else is ever read: no path comes from a URL."""

HEADERS = {
    # No frame-ancestors: editors show the page in a frame, from addresses of their own.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'none'",
    "Referrer-Policy": "no-referrer",  # the address holds the token
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


Check = Callable[[object], bool]


def _between(least: float, most: float) -> Check:
    """A number within limits: no NaN, no infinity, nothing that only looks like one."""
    return lambda value: isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST_NAME


def _are_names(value: object) -> bool:
    return isinstance(value, list) and len(value) <= MOST_NAMES and all(map(_is_name, value))


COMMANDS: Mapping[str, Mapping[str, Check]] = {
    "hush": {},
    "pause": {},
    "resume": {},
    "restart": {},
    "seek": {"beat": _between(0, LAST_BEAT)},
    "speed": {"factor": _between(0.1, 4)},
    "silence": {"muted": _are_names, "soloed": _are_names},
    # A start pose in metres and degrees, as improv.toml has it, within the limits it has there.
    "place": {
        "robot": _is_name,
        "x": _between(-1000, 1000),
        "y": _between(-1000, 1000),
        "heading": _between(-360, 360),
    },
}
"""What a page may ask of those who conduct, and what each value must be. Anything else is dropped."""

WINDOW: Mapping[str, Check] = {
    "generation": _between(0, LAST_BEAT),
    "from": _between(0, LAST_BEAT),
    "to": _between(0, LAST_BEAT),
}
"""What a page may ask of the viewer: what is to come."""


class Viewer:
    """The page's server, on this machine's loopback address only.

    `snapshot` is called 60 times a second while a page is open, and `command` with each command from a page (and with
    `WATCHED` when one is opened), both from the server's thread: they must return at once. A page keeps its place
    across servers that share `port` and `token`.
    Raises OSError if the port is taken; port 0 is any free one.
    """

    def __init__(
        self,
        port: int,
        snapshot: Callable[[], Snapshot],
        command: Callable[[dict[str, Any]], None],
        token: str | None = None,
    ) -> None:
        self._snapshot = snapshot
        self._command = command
        self._token = token or secrets.token_urlsafe()
        self._score: Score | None = None
        self._generation = 0
        self._latest: dict[str, str] = {}
        self._drawn: dict[str, object] = {}
        self._pages: dict[_Outbox, web.Request] = {}
        self._asked: queue.SimpleQueue[_Outbox | None] = queue.SimpleQueue()
        self._windows: dict[tuple[float, float], str] = {}
        self._watched = asyncio.Event()
        self._stop = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        self._socket = socket.create_server((HOST, port))
        self._port: int = self._socket.getsockname()[1]
        self._hosts = {f"{name}:{self._port}" for name in (HOST, "localhost")}
        application = self._application()
        self._thread = threading.Thread(target=self._run, args=(application,), name="improv-viewer", daemon=True)
        self._thread.start()
        # What is to come is computed beside everything else: a page that asks for much holds up neither the others nor
        # the robots. Nobody waits for this thread at the end.
        threading.Thread(target=self._foresee, name="improv-windows", daemon=True).start()

    @property
    def url(self) -> str:
        """The page's address, with the token that opens it."""
        return f"http://{HOST}:{self._port}/?token={self._token}"

    def publish(self, message: dict[str, Any]) -> None:
        """Send a message to every page, and to later ones until another message has its "type"."""
        kind, text = message["type"], json.dumps(message)
        with suppress(RuntimeError):  # closed already
            self._loop.call_soon_threadsafe(self._put, kind, text)

    def show(self, score: Score, generation: int) -> None:
        """Show what is to be played, once the player's messages have this generation."""
        self._score, self._generation = score, generation
        self._windows = {}
        self.publish(about(score, generation))

    def close(self) -> None:
        """End all connections and the thread."""
        with suppress(RuntimeError):  # closed already
            self._loop.call_soon_threadsafe(self._stop.set)
        self._asked.put(None)
        self._thread.join()

    def _run(self, application: web.Application) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve(application))
        finally:
            self._loop.close()

    async def _serve(self, application: web.Application) -> None:
        from aiohttp import web

        runner = web.AppRunner(application, access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        await web.SockSite(runner, self._socket).start()
        watching = asyncio.create_task(self._watch())
        await self._stop.wait()
        watching.cancel()
        for request in self._pages.values():
            if request.transport is not None:
                request.transport.abort()  # a polite end would wait for pages that no longer listen
        await runner.cleanup()

    def _application(self) -> web.Application:
        from aiohttp import WSMsgType, web

        folder = Path(__file__).parent
        index = (folder / "index.html").read_bytes()
        files = {path: (folder / path[1:]).read_bytes() for path in FILES}

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            # A stranger's page may point a name of its own at this machine; only our own names are answered.
            if request.headers.get("Host") not in self._hosts:
                raise web.HTTPForbidden
            return await handler(request)

        async def harden(request: web.Request, response: web.StreamResponse) -> None:
            response.headers.update(HEADERS)

        async def show_page(request: web.Request) -> web.Response:
            self._check_token(request)
            return web.Response(body=index, content_type="text/html", charset="utf-8")

        async def show_file(request: web.Request) -> web.Response:
            return web.Response(body=files[request.path], content_type=FILES[request.path], charset="utf-8")

        async def live(request: web.Request) -> web.WebSocketResponse:
            self._check_token(request)
            if request.headers.get("Origin") != f"http://{request.host}":
                raise web.HTTPForbidden
            if len(self._pages) >= MAX_PAGES:
                raise web.HTTPServiceUnavailable
            # Nothing is buffered beyond what the system takes, so that a slow page sees the present.
            page = web.WebSocketResponse(heartbeat=20, compress=False, max_msg_size=MAX_MESSAGE, writer_limit=0)
            outbox = self._join(request)
            try:
                await page.prepare(request)
                sending = asyncio.create_task(outbox.empty_into(page))
                self._command(WATCHED)
                async for message in page:
                    if message.type is WSMsgType.TEXT:
                        self._receive(message.data, outbox)
                sending.cancel()
            finally:
                del self._pages[outbox]
                if not self._pages:
                    self._watched.clear()
            return page

        application = web.Application(middlewares=[guard])
        application.on_response_prepare.append(harden)
        application.router.add_get("/", show_page)
        application.router.add_get("/live", live)
        for path in FILES:
            application.router.add_get(path, show_file)
        return application

    def _check_token(self, request: web.Request) -> None:
        from aiohttp import web

        if not secrets.compare_digest(request.query.get("token", "").encode(), self._token.encode()):
            raise web.HTTPForbidden(text="Open the page with the address that Improv printed.")

    def _join(self, request: web.Request) -> _Outbox:
        """A new page's outbox, filled with what the other pages know."""
        self._draw()
        outbox = _Outbox()
        for kind, text in self._latest.items():
            outbox.put(kind, text)
        self._pages[outbox] = request
        self._watched.set()
        return outbox

    def _put(self, kind: str, text: str) -> None:
        self._latest[kind] = text
        for outbox in self._pages:
            outbox.put(kind, text)

    def _receive(self, text: str, outbox: _Outbox) -> None:
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            return
        kind = message.get("type") if isinstance(message, dict) else None
        if not isinstance(kind, str):
            return
        if kind == "window" and _fits(message, WINDOW):
            outbox.asked = message
            self._asked.put(outbox)
        elif kind in COMMANDS and _fits(message, COMMANDS[kind]):
            self._command({"type": kind, **{name: message[name] for name in COMMANDS[kind]}})

    def _foresee(self) -> None:
        """Answer who asks for windows, in turns, the latest question of each page only."""
        while (outbox := self._asked.get()) is not None:
            question, outbox.asked = outbox.asked, None
            score, generation, known = self._score, self._generation, self._windows
            if question is None or score is None or question["generation"] != generation:
                continue
            start = question["from"]
            end = min(question["to"], start + MOST_BEATS)
            text = known.get((start, end))
            if text is None:
                answer = {"type": "window", "generation": generation, "from": start, "to": end}
                text = json.dumps({**answer, "robots": window(score, start, end)})
                if len(known) >= WINDOWS_KEPT:
                    del known[next(iter(known))]
                known[start, end] = text
            try:
                self._loop.call_soon_threadsafe(outbox.put, "window", text)
            except RuntimeError:  # closed
                return

    async def _watch(self) -> None:
        while True:
            await self._watched.wait()
            self._draw()
            await asyncio.sleep(FRAME)

    def _draw(self) -> None:
        """Send the robots and their poses where they have changed."""
        snapshot = self._snapshot()
        robots = {name: {"radius": radius} for name, radius in snapshot.radii.items()}
        poses = {
            name: [round(pose.x, 4), round(pose.y, 4), round(pose.z, 4), round(pose.heading, 5)]
            for name, pose in snapshot.poses.items()
        }
        if robots != self._drawn.get("robots"):
            self._put("robots", json.dumps({"type": "robots", "robots": robots}))
        if poses != self._drawn.get("poses"):
            self._put("poses", json.dumps({"type": "poses", "at": round(snapshot.at, 5), "poses": poses}))
        self._drawn = {"robots": robots, "poses": poses}


def _fits(message: Mapping[str, object], checks: Mapping[str, Check]) -> bool:
    return all(check(message.get(name)) for name, check in checks.items())


class _Outbox:
    """What one page has yet to get: the latest message of each type, so that a slow page skips frames."""

    def __init__(self) -> None:
        self._waiting: dict[str, str] = {}
        self._filled = asyncio.Event()
        self.asked: dict[str, Any] | None = None
        """The latest question for a window that has not been looked at."""

    def put(self, kind: str, text: str) -> None:
        self._waiting[kind] = text
        self._filled.set()

    async def empty_into(self, page: web.WebSocketResponse) -> None:
        while True:
            await self._filled.wait()
            self._filled.clear()
            while self._waiting:
                kind = next(iter(self._waiting))
                with suppress(ConnectionError):  # gone: the reading side ends the page
                    await page.send_str(self._waiting.pop(kind))
