"""What children's browsers load and send, over HTTP (aiohttp, imported lazily), on a thread of its own."""

from __future__ import annotations

import asyncio
import gzip
import json
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from improv_core.classroom.roster import ForbiddenError, Member, Room, guess, join, send, without
from improv_core.page.connection_limit import SILENT_LIMIT, Connections
from improv_core.page.song_file import CONTENT_TYPES
from improv_core.website.build import HEAD, MARK

if TYPE_CHECKING:
    import socket

    from aiohttp import web
    from aiohttp.typedefs import Handler, Middleware

MOST_BYTES = 700_000
"""Of a request: enough for the longest dance, however JSON writes it."""
BODY_LIMIT = 20.0
"""Seconds in which a request has to arrive as a whole."""
CLASS = '<meta name="improv-class" content="">'
"""What tells the page that it can send its dance to a teacher."""
TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json; charset=utf-8",
    ".packed": "application/octet-stream",
    ".svg": "image/svg+xml",
    ".mjs": "text/javascript; charset=utf-8",
    ".wasm": "application/wasm",
    ".zip": "application/zip",
    **CONTENT_TYPES,
}
LEFT_OUT = (MARK, "service-worker.js")
HEADERS = {"Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff", "Cache-Control": "no-cache"}


class SiteFolderError(Exception):
    """A folder is no website that `improv site` has built. The message is one line that says what to do."""


class File(NamedTuple):
    """A file of the website, compressed if that is `smaller`."""

    data: bytes
    smaller: bytes | None
    content_type: str


def files_of(site: Path) -> Mapping[str, File]:
    """The files of a built website by path. All are read at once: no path ever comes from a URL. Raises
    SiteFolderError and OSError."""
    if not (site / MARK).is_file() or not (site / "website" / "class.js").is_file():
        raise SiteFolderError(f"{site} is no website of this version: run `improv site {site}` first")
    found = {}
    for path in sorted(site.rglob("*")):
        name = path.relative_to(site).as_posix()
        if path.suffix not in TYPES or name in LEFT_OUT or not path.is_file():
            continue
        data = path.read_bytes()
        if name == "index.html":
            data = data.decode().replace(HEAD, f"{HEAD}\n    {CLASS}", 1).encode()
        smaller = gzip.compress(data, 6, mtime=0)
        found[f"/{name}"] = File(data, smaller if len(smaller) < 0.9 * len(data) else None, TYPES[path.suffix])
    return {**found, "/": found["/index.html"]}


class Children:
    """The children's server. `joined` and `handed` are called on its thread: a child has come, or has sent a dance."""

    def __init__(
        self,
        listening: socket.socket,
        files: Mapping[str, File],
        code: str,
        joined: Callable[[Member], None],
        handed: Callable[[Member, str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._socket, self._files = listening, files
        host, port = listening.getsockname()[:2]
        self._host = f"{host}:{port}"
        self._room = Room(code)
        self._joined, self._handed, self._clock = joined, handed, clock
        self._loop = asyncio.new_event_loop()
        self._stop = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="improv-children", daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        return f"http://{self._host}/"

    def remove(self, number: int) -> None:
        """From now on, this child can't send anything."""
        self._soon(self._remove, number)

    def close(self) -> None:
        """End all connections and the thread."""
        self._soon(self._stop.set)
        self._thread.join()

    def _soon(self, what: Callable[..., None], *values: object) -> None:
        with suppress(RuntimeError):  # already closed
            self._loop.call_soon_threadsafe(what, *values)

    def _remove(self, number: int) -> None:
        self._room = without(self._room, number)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            self._loop.close()

    async def _serve(self) -> None:
        from aiohttp import web

        application = web.Application(middlewares=[self._guard()], client_max_size=MOST_BYTES)
        application.router.add_post("/class/join", self._join)
        application.router.add_post("/class/send", self._send)
        for path in self._files:
            application.router.add_get(path, self._show)
        runner = web.AppRunner(application, access_log=None, shutdown_timeout=1.0, keepalive_timeout=SILENT_LIMIT)
        await runner.setup()
        assert runner.server is not None
        self._connections = Connections(runner.server)
        server = await self._loop.create_server(self._connections.connect, sock=self._socket)
        await self._stop.wait()
        server.close()
        await runner.cleanup()

    def _guard(self) -> Middleware:
        from aiohttp import web

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            # Another website may point a name of its own at this machine.
            if request.headers.get("Host") != self._host:
                raise web.HTTPForbidden
            if request.method == "POST" and request.headers.get("Origin") != f"http://{self._host}":
                raise web.HTTPForbidden
            with self._connections.busy(request):
                return await handler(request)

        return guard

    async def _show(self, request: web.Request) -> web.Response:
        from aiohttp import web

        file = self._files[request.path]
        headers = {**HEADERS, "Content-Type": file.content_type}
        if file.smaller and "gzip" in request.headers.get("Accept-Encoding", ""):
            return web.Response(body=file.smaller, headers={**headers, "Content-Encoding": "gzip"})
        return web.Response(body=file.data, headers=headers)

    async def _join(self, request: web.Request) -> web.Response:
        code, name = await _texts(request, "code", "name")
        secret = secrets.token_urlsafe()
        try:
            self._room, is_right = guess(self._room, code, self._clock())
            if not is_right:
                raise ForbiddenError(403, "this is not the code of the room: look at it again")
            self._room, member = join(self._room, name, secret)
        except ForbiddenError as problem:
            return _answer(problem.status, {"problem": str(problem)})
        self._joined(member)
        return _answer(200, {"secret": secret, "name": member.name})

    async def _send(self, request: web.Request) -> web.Response:
        secret, text = await _texts(request, "secret", "text")
        try:
            self._room, member = send(self._room, secret, text, self._clock())
        except ForbiddenError as problem:
            return _answer(problem.status, {"problem": str(problem)})
        self._handed(member, text)
        return _answer(200, {"name": member.name})


async def _texts(request: web.Request, *names: str) -> list[str]:
    """The values of a JSON object that has exactly these, all of them texts."""
    from aiohttp import web

    try:
        found = json.loads(await asyncio.wait_for(request.read(), BODY_LIMIT))
    except asyncio.TimeoutError:
        raise web.HTTPRequestTimeout from None
    except (ValueError, RecursionError):
        raise web.HTTPBadRequest from None
    if not isinstance(found, dict) or found.keys() != set(names):
        raise web.HTTPBadRequest
    values = [found[name] for name in names]
    if not all(map(_is_text, values)):
        raise web.HTTPBadRequest
    return values


def _is_text(value: object) -> bool:
    """Whether it is a text that can be written as UTF-8, without half of a pair of surrogates."""
    if not isinstance(value, str):
        return False
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True


def _answer(status: int, value: Mapping[str, str]) -> web.Response:
    from aiohttp import web

    return web.json_response(value, status=status, headers=HEADERS)
