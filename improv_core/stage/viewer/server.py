"""Serves the page and keeps it up to date over a WebSocket, from a thread of its own (aiohttp, imported lazily)."""

from __future__ import annotations

import asyncio
import atexit
import json
import queue
import re
import secrets
import socket
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from improv_core.score.score import Score
from improv_core.score.svg import plot
from improv_core.stage.protocol import (
    FASTEST,
    LAST_BEAT,
    SLOWEST,
    AskWindow,
    DrawnPoses,
    DrawnRobot,
    DrawnRobots,
    PageRequest,
    ShownScore,
    Stopped,
    TransportMessage,
    Watched,
    Window,
)
from improv_core.stage.viewer.outbox import Outbox, told
from improv_core.stage.window import MOST_MOMENTS, about, window

if TYPE_CHECKING:
    from aiohttp import web
    from aiohttp.typedefs import Handler

    from improv_core.stage.sinks.collisions import Bump
    from improv_core.stage.sinks.simulator import Snapshot

HOST = "127.0.0.1"
OWN_HOST = re.compile(r"(127\.0\.0\.1|localhost):\d+")
FRAME = 1 / 60
PARTING = 0.25
"""Seconds that pages have at the end to be told why."""
MAX_PAGES = 64
MAX_MESSAGE = 256 * 1024
"""Bytes of a message from a page: enough to silence every robot by its name."""
MOST_NAMES, LONGEST_NAME = 1000, 100
MOST_BEATS = 256
"""In one window."""
WINDOWS_KEPT = 64
"""Windows told to one page that the next may ask for."""
WATCHED: Watched = {"type": "watched"}
FILES = {
    "/page.css": "text/css",
    "/panels.css": "text/css",
    "/anchor.js": "text/javascript",
    "/bumps.js": "text/javascript",
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
    "/world.js": "text/javascript",
}
"""The files a page asks for, and their content types. Nothing else is ever read: no path comes from a URL."""

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


Check = Callable[[object], bool]


def _between(least: float, most: float) -> Check:
    """A number within limits: no NaN, no infinity, nothing that only looks like one."""
    return lambda value: isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST_NAME


def _are_names(value: object) -> bool:
    return isinstance(value, list) and len(value) <= MOST_NAMES and all(map(_is_name, value))


START: Mapping[str, Check] = {"x": _between(-1000, 1000), "y": _between(-1000, 1000), "heading": _between(-360, 360)}
"""A start pose in metres and degrees, as improv.toml has it, within the limits it has there."""


def _are_starts(value: object) -> bool:
    """Robots' names, each with a start and nothing else."""
    return (
        isinstance(value, dict)
        and _are_names([*value])
        and all(
            isinstance(pose, dict) and pose.keys() == START.keys() and _fits(pose, START) for pose in value.values()
        )
    )


COMMANDS: Mapping[str, Mapping[str, Check]] = {
    "hush": {},
    "pause": {},
    "resume": {},
    "restart": {},
    "seek": {"beat": _between(0, LAST_BEAT)},
    "speed": {"factor": _between(SLOWEST, FASTEST)},
    "silence": {"muted": _are_names, "soloed": _are_names},
    "place": {"starts": _are_starts},
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
    `WATCHED` when one is opened), both from the server's thread: they must return at once. With `takes_starts`, one
    may be `place`. A page keeps its place across servers that share `port` and `token`.
    Raises OSError if the port is taken; port 0 is any free one.
    """

    def __init__(
        self,
        port: int,
        snapshot: Callable[[], Snapshot],
        command: Callable[[PageRequest | Watched], None],
        *,
        takes_starts: bool = False,
        token: str | None = None,
    ) -> None:
        self._snapshot = snapshot
        self._command = command
        self._takes_starts = takes_starts
        self._token = token or secrets.token_urlsafe()
        self._score: Score | None = None
        self._generation = 0
        self._picture: tuple[Score, str] | None = None
        self._latest: dict[str, str] = {}
        self._drawn: dict[str, object] = {}
        self._bumps: tuple[Bump, ...] = ()
        self._pages: dict[Outbox, web.Request] = {}
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._windows: dict[tuple[float, float], str] = {}
        self._watched = asyncio.Event()
        self._stop = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        self._socket = socket.create_server((HOST, port))
        self._port: int = self._socket.getsockname()[1]
        application = self._application()
        self._thread = threading.Thread(target=self._run, args=(application,), name="improv-viewer", daemon=True)
        self._thread.start()
        # What is to come is computed beside everything else: a page that asks for much holds up neither the others nor
        # the robots. Nobody waits for this thread at the end.
        threading.Thread(target=self._compute, name="improv-windows", daemon=True).start()
        atexit.register(self.close)  # a page should know whether a performance is over or has broken off

    @property
    def url(self) -> str:
        """The page's address, with the token that opens it."""
        return f"http://{HOST}:{self._port}/?token={self._token}"

    def publish(self, message: TransportMessage | Stopped | ShownScore) -> None:
        """Send a message to every page, and to later ones until another has its "type"."""
        self._soon(self._put, message["type"], json.dumps(message))

    def show(self, score: Score, generation: int) -> None:
        """Show what is to be played, once the player's messages have this generation."""
        self._score, self._generation = score, generation
        self._windows = {}
        self.publish(about(score, generation, takes_starts=self._takes_starts))

    def close(self) -> None:
        """Send what has been published, end all connections and the thread."""
        atexit.unregister(self.close)
        self._soon(self._stop.set)
        self._work.put(None)
        self._thread.join()

    def _soon(self, what: Callable[..., None], *values: object) -> None:
        """Have the server's thread do something."""
        with suppress(RuntimeError):  # closed already
            self._loop.call_soon_threadsafe(what, *values)

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
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(asyncio.gather(*(outbox.emptied() for outbox in self._pages)), PARTING)
        for request in self._pages.values():
            if request.transport is not None:
                request.transport.abort()  # a polite end would wait for pages that no longer listen
        await runner.cleanup()

    def _application(self) -> web.Application:
        from aiohttp import WSMsgType, web

        folder = Path(__file__).parent / "page"
        index = (folder / "index.html").read_bytes()
        files = {path: (folder / path[1:]).read_bytes() for path in FILES}

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            # A stranger's page may point a name of its own at this machine; only this machine's names are answered. The
            # port may be another: that of the tunnel by which an editor brings the page to where its window is.
            if not OWN_HOST.fullmatch(request.headers.get("Host", "")):
                raise web.HTTPForbidden
            return await handler(request)

        async def harden(request: web.Request, response: web.StreamResponse) -> None:
            response.headers.update(HEADERS)

        async def show_page(request: web.Request) -> web.Response:
            self._check_token(request)
            return web.Response(body=index, content_type="text/html", charset="utf-8")

        async def show_file(request: web.Request) -> web.Response:
            return web.Response(body=files[request.path], content_type=FILES[request.path], charset="utf-8")

        async def show_path(request: web.Request) -> web.Response:
            self._check_token(request)
            if "Origin" in request.headers:  # browsers leave it out where a page asks for what is its own
                _check_origin(request)
            drawn: asyncio.Future[str | None] = self._loop.create_future()
            self._work.put(partial(self._draw_path, drawn))
            text = await drawn
            if text is None:
                raise web.HTTPNotFound
            return web.Response(text=text, content_type="image/svg+xml")

        async def live(request: web.Request) -> web.WebSocketResponse:
            self._check_token(request)
            _check_origin(request)
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
        application.router.add_get("/path.svg", show_path)
        application.router.add_get("/live", live)
        for path in FILES:
            application.router.add_get(path, show_file)
        return application

    def _check_token(self, request: web.Request) -> None:
        from aiohttp import web

        if not secrets.compare_digest(request.query.get("token", "").encode(), self._token.encode()):
            raise web.HTTPForbidden(text="Open the page with the address that Improv printed.")

    def _join(self, request: web.Request) -> Outbox:
        """A new page's outbox, filled with what the other pages know."""
        self._draw()
        outbox = Outbox()
        for kind, text in self._latest.items():
            outbox.put(kind, text)
        if self._bumps:
            outbox.put("past", told(self._bumps, past=True))
        self._pages[outbox] = request
        self._watched.set()
        return outbox

    def _put(self, kind: str, text: str) -> None:
        self._latest[kind] = text
        for outbox in self._pages:
            outbox.put(kind, text)

    def _receive(self, text: str, outbox: Outbox) -> None:
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            return
        kind = message.get("type") if isinstance(message, dict) else None
        if not isinstance(kind, str):
            return
        if kind == "window" and _fits(message, WINDOW):
            outbox.asked = cast("AskWindow", message)
            self._work.put(partial(self._foresee, outbox))
        elif kind in COMMANDS and _fits(message, COMMANDS[kind]):
            self._command(cast("PageRequest", {"type": kind, **{name: message[name] for name in COMMANDS[kind]}}))

    def _compute(self) -> None:
        while (work := self._work.get()) is not None:
            try:
                work()
            except Exception as problem:  # one window, or one picture, is missing: the next ones are not
                print(f"the page: {problem!r}", file=sys.stderr)

    def _foresee(self, outbox: Outbox) -> None:
        """Answer the latest question of a page for a window."""
        question, outbox.asked = outbox.asked, None
        score, generation, known = self._score, self._generation, self._windows
        if question is None or score is None or question["generation"] != generation:
            return
        start = question["from"]
        end = min(question["to"], start + MOST_BEATS)
        text = known.get((start, end))
        if text is None:
            robots = window(score, start, end)
            answer: Window = {"type": "window", "generation": generation, "from": start, "to": end, "robots": robots}
            text = json.dumps(answer)
            if len(known) >= WINDOWS_KEPT:
                del known[next(iter(known))]
            known[start, end] = text
        self._soon(outbox.put, "window", text)

    def _draw_path(self, drawn: asyncio.Future[str | None]) -> None:
        """Tell the picture of the score's paths, None where there is no score; the same score is drawn once."""
        score, known, text = self._score, self._picture, None
        try:
            if score and (not known or known[0] is not score):
                known = self._picture = score, plot(score, most_moments=MOST_MOMENTS // max(len(score.parts), 1))
            text = known[1] if score and known else None
        finally:
            self._soon(_settle, drawn, text)

    async def _watch(self) -> None:
        while True:
            await self._watched.wait()
            self._draw()
            await asyncio.sleep(FRAME)

    def _draw(self) -> None:
        """Send the robots, their poses in the same order, and bumps, where there is something new."""
        snapshot = self._snapshot()
        robots: dict[str, DrawnRobot] = {name: {"radius": radius} for name, radius in snapshot.radii.items()}
        poses = [
            [round(pose.x, 4), round(pose.y, 4), round(pose.z, 4), round(pose.heading, 4)]
            for pose in map(snapshot.poses.__getitem__, robots)
        ]
        if robots != self._drawn.get("robots"):
            drawn: DrawnRobots = {"type": "robots", "robots": robots}
            self._put("robots", json.dumps(drawn))
        if {"robots": robots, "poses": poses} != self._drawn:
            at, placed = round(snapshot.at, 4), snapshot.placed
            message: DrawnPoses = {"type": "poses", "at": at, "placed": placed, "poses": poses}
            self._put("poses", json.dumps(message, separators=(",", ":")))
        self._drawn = {"robots": robots, "poses": poses}
        known = set(map(id, self._bumps))  # a dance that is played again may have equal ones
        new = [bump for bump in snapshot.bumps if id(bump) not in known]
        self._bumps = snapshot.bumps
        for outbox in self._pages if new else ():
            outbox.add_bumps(new)


def _check_origin(request: web.Request) -> None:
    from aiohttp import web

    if request.headers.get("Origin") != f"http://{request.host}":
        raise web.HTTPForbidden


def _settle(drawn: asyncio.Future[str | None], text: str | None) -> None:
    if not drawn.done():  # who asked may be gone
        drawn.set_result(text)


def _fits(message: Mapping[str, object], checks: Mapping[str, Check]) -> bool:
    return all(check(message.get(name)) for name, check in checks.items())
