"""The children's website and their requests, over HTTP, in a process of its own: however much children send, the
teacher's process gets little of it. `children.py` is its parent's side."""

from __future__ import annotations

import asyncio
import gzip
import json
import os
import secrets
import socket
import sys
import threading
import time
from collections.abc import Callable, Collection, Coroutine, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict, cast

from aiohttp import web

from improv_core.classroom.kept import Folder, FolderError
from improv_core.classroom.messages import DanceRead, FromChildren, Handed, Remove, Serving
from improv_core.classroom.roster import (
    LONGEST_DANCE,
    SILENT,
    ForbiddenError,
    Room,
    counted,
    guess,
    join,
    noticed,
    people,
    send,
    without,
)
from improv_core.classroom.turns import Turns
from improv_core.page.connections import LOOK_PERIOD, Connections
from improv_core.page.web_server import runner_of
from improv_core.protocol.fields import Text
from improv_core.protocol.json_lines import own_output
from improv_core.score.json_types import fits
from improv_core.score.music import CONTENT_TYPES
from improv_core.storage.atomic_write import why
from improv_core.website.build import HEAD, MARK

if TYPE_CHECKING:
    from aiohttp.typedefs import Handler

MAX_BYTES = 4 * LONGEST_DANCE
"""The most bytes of a dance, as UTF-8."""
MAX_JOINING = 2_000
"""The most bytes of a request to join: a code and a name."""
SLICE = 32_768
"""Bytes of a file that are sent before the browser has to read some of them."""
SEND_BUFFER = 128_000
"""The most bytes that the system keeps of each connection until its browser reads them."""
LINGER = 1.0
"""Seconds in which the rest of a refused request is read, so that its browser gets the answer."""
COOKIE = "improv-class"
"""The cookie that identifies a browser: each one has one place in the class."""
NICENESS = 5
"""The process's niceness: playing comes first."""
CLASS = '<meta name="improv-class" content="">'
"""Marks a page that can send its dance to a teacher."""
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


class JoinRequest(TypedDict):
    """A child wants to join."""

    code: Text
    name: Text


class File(NamedTuple):
    """A file of the website, with its compressed form if that is `smaller`."""

    data: bytes
    smaller: bytes | None
    content_type: str


def files_of(site: Path) -> Mapping[str, File]:
    """The files of a built website by path. All are read at once: no path ever comes from a URL. Raises OSError."""
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


class StudentServer:
    """The children's server on a socket. `tell` gets messages for the teacher. The class continues as its folder has
    kept it; otherwise it has this code. Raises FolderError."""

    def __init__(
        self,
        listening: socket.socket,
        files: Mapping[str, File],
        code: str,
        folder: Folder,
        tell: Callable[[FromChildren], None],
    ) -> None:
        self._socket, self._files = listening, files
        host, port = listening.getsockname()[:2]
        self._host = f"{host}:{port}"
        self._tell = tell
        self._turns = Turns(self._read)
        self._sending: set[int] = set()
        self._folder, self._keeping = folder, asyncio.Lock()
        self._problem: str | None = None
        self._written: Room | None = None
        self._background: set[asyncio.Task[None]] = set()
        self._unread: dict[int, Handed] = {}  # behind an earlier dance of the same child, which is read first
        self._room = folder.room(code, time.time())
        self._told: Mapping[int, tuple[str, bool]] = {}  # the children, as the teacher knows them
        self.code = self._room.code

    @property
    def address(self) -> str:
        return f"http://{self._host}/"

    def remove(self, numbers: Collection[int]) -> None:
        """Refuse everything that these children send from now on."""
        self._become(without(self._room, numbers))
        self._soon(self._keep_list())

    async def serve(self) -> None:
        """Serve children forever."""
        application = web.Application(middlewares=[self._guard], client_max_size=MAX_BYTES)
        application.router.add_post("/class/join", self._join)
        application.router.add_post("/class/send", self._send)
        application.router.add_post("/class/{what:here|left}", self._notice)
        for path in self._files:
            application.router.add_get(path, self._show, allow_head=False)
        runner = runner_of(application, lingering_time=LINGER)
        await runner.setup()
        assert runner.server is not None
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
        self._connections = Connections(runner.server)
        self._continue()
        await asyncio.gather(self._connections.serve(self._socket), self._turns.serve(), self._watch())

    def _continue(self) -> None:
        """Tell the teacher of the children and the dances that were kept."""
        self._become(self._room)
        self._report("")
        for member in (*self._room.away, *self._room.members.values()):
            for place, (count, sent, text) in enumerate(self._folder.latest(member)):
                dance = Handed(type="handed", number=member.number, count=count, sent=sent, text=text)
                if place == 0:
                    self._hand_in(dance)
                else:
                    self._unread[member.number] = dance

    def _become(self, room: Room) -> None:
        """Change the class, and tell the teacher of its children."""
        before, after = self._told, people(room, time.monotonic())
        self._room, self._told = room, after
        gone = before.keys() - after.keys()
        self._turns.forget(gone)
        for number in gone:
            self._unread.pop(number, None)
            self._tell({"type": "gone", "number": number})
        for number, (name, here) in after.items():
            if before.get(number) != (name, here):
                self._tell({"type": "joined", "number": number, "name": name, "here": here})

    async def _watch(self) -> None:
        """Tell the teacher of children whose pages were opened, closed, or silent for too long."""
        while True:
            await asyncio.sleep(LOOK_PERIOD)
            self._become(self._room)

    def _hand_in(self, dance: Handed) -> None:
        self._tell(dance)
        self._turns.put(dance)

    def _read(self, found: DanceRead) -> None:
        """Take a dance that was read."""
        self._tell(found)
        if found["ok"]:
            self._room = counted(self._room, found["number"], found["count"])
            self._soon(self._keep_list())
        if dance := self._unread.pop(found["number"], None):
            self._hand_in(dance)

    def _soon(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.ensure_future(work)
        self._background.add(task)
        task.add_done_callback(self._background.discard)

    async def _keep_list(self) -> None:
        """Keep the list of children, unless it is kept already."""

        def keep() -> None:
            if (room := self._room) is not self._written:
                self._folder.keep(room, time.time())
                self._written = room

        await self._keep(keep)

    async def _keep(self, write: Callable[[], None]) -> None:
        """Write something into the folder, and tell the teacher if that fails."""
        async with self._keeping:
            try:
                await asyncio.to_thread(write)
            except OSError as error:
                self._report(f"what children send now is not kept: {why(error)}")
            else:
                self._report("")

    def _report(self, problem: str) -> None:
        if problem != self._problem:
            self._problem = problem
            self._tell({"type": "keeping", "folder": str(self._folder.path.absolute()), "problem": problem})

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        # Another website may point a name of its own at this machine.
        if request.headers.get("Host") != self._host:
            raise web.HTTPForbidden
        if request.method == "POST" and request.headers.get("Origin") != f"http://{self._host}":
            raise web.HTTPForbidden
        self._connections.progressed(request.protocol)
        try:
            return await handler(request)
        except ConnectionError:  # the browser is gone, which is no error of the server
            return web.Response()

    async def _show(self, request: web.Request) -> web.StreamResponse:
        file = self._files[request.path]
        response = web.StreamResponse(headers={**HEADERS, "Content-Type": file.content_type})
        data = file.data
        if file.smaller and "gzip" in request.headers.get("Accept-Encoding", ""):
            data = file.smaller
            response.headers["Content-Encoding"] = "gzip"
        response.content_length = len(data)
        await response.prepare(request)
        whole = memoryview(data)  # a response would copy the data that its browser doesn't read
        for start in range(0, len(data), SLICE):
            await response.write(whole[start : start + SLICE])
            self._connections.progressed(request.protocol)
        await response.write_eof()
        return response

    async def _join(self, request: web.Request) -> web.Response:
        asked = _join_request(await _body(request, MAX_JOINING))
        secret, fresh = secrets.token_urlsafe(), secrets.token_urlsafe()
        known = {each.browser for each in (*self._room.members.values(), *self._room.away)}
        given = request.cookies.get(COOKIE, "")
        try:
            self._room, is_right = guess(self._room, request.remote or "", asked["code"], time.monotonic())
            if not is_right:
                raise ForbiddenError(403, "that is not the code of the room: check it and type it again")
            room, member = join(self._room, asked["name"], secret, given if given in known else fresh)
        except ForbiddenError as problem:
            return _answer(problem.status, {"problem": str(problem)})
        self._become(noticed(room, secret, time.monotonic()))
        await self._keep_list()
        answer = _answer(200, {"secret": secret, "name": member.name})
        answer.set_cookie(COOKIE, member.browser, path="/class", httponly=True, samesite="Strict")
        return answer

    async def _send(self, request: web.Request) -> web.Response:
        """Receive a dance. Only requests of members are read, and only one at a time for each."""
        secret = _secret(request)
        try:
            room, member = send(self._room, secret, time.monotonic())
            self._become(room)
            if member.number in self._sending:
                raise ForbiddenError(429, "your last one is still on its way: wait a second")
            self._sending.add(member.number)
            try:
                text = await _body(request, MAX_BYTES)
            finally:
                self._sending.discard(member.number)
            if len(text) > LONGEST_DANCE:
                raise ForbiddenError(413, f"this dance is longer than {LONGEST_DANCE:,} characters")
            if secret not in self._room.members:
                raise ForbiddenError(403, "join the class first")  # the teacher removed it meanwhile
        except ForbiddenError as problem:
            return _answer(problem.status, {"problem": str(problem)})
        now = time.time()
        await self._keep(lambda: self._folder.add(member, text, now))
        self._unread.pop(member.number, None)
        self._hand_in({"type": "handed", "number": member.number, "count": member.count, "sent": now, "text": text})
        return _answer(200, {"name": member.name})

    async def _notice(self, request: web.Request) -> web.Response:
        """Note that a child's page is open, or that it was closed."""
        seen = time.monotonic() if request.match_info["what"] == "here" else -SILENT
        try:
            self._room = noticed(self._room, _secret(request), seen)  # told once a second at most
        except ForbiddenError as problem:
            return _answer(problem.status, {"problem": str(problem)})
        return web.Response(status=204)


def _secret(request: web.Request) -> str:
    """Return the secret with which a child's page has signed a request."""
    return request.headers.get("Authorization", "").removeprefix("Bearer ")


async def _body(request: web.Request, most: int) -> str:
    """Return the text of a request, which must declare its length: at most this many bytes."""
    if "Content-Encoding" in request.headers:
        raise web.HTTPUnsupportedMediaType
    if request.content_length is None:
        raise web.HTTPLengthRequired
    if request.content_length > most:
        raise web.HTTPRequestEntityTooLarge(most, request.content_length)
    try:
        return (await request.read()).decode()
    except UnicodeDecodeError:
        raise web.HTTPBadRequest from None


def _join_request(body: str) -> JoinRequest:
    """Return the request in a body."""
    try:
        found = json.loads(body)
    except (ValueError, RecursionError):
        found = None
    if not fits(found, JoinRequest):
        raise web.HTTPBadRequest
    return cast(JoinRequest, found)


def _answer(status: int, value: Mapping[str, str]) -> web.Response:
    return web.json_response(value, status=status, headers=HEADERS)


async def _serve(site: Path, folder: Path, address: str, port: int) -> None:
    """Serve until standard input is closed. Its first line has a code for the room, and the others children to
    remove."""
    say = own_output()
    with suppress(AttributeError, OSError):  # not on Windows
        os.nice(NICENESS)
    code = json.loads(sys.stdin.buffer.readline())["code"]
    try:
        listening = socket.create_server((address, port))
    except OSError as error:
        problem = f"port {port} of {address} can't be used: {error.strerror}"
        say(Serving(type="serving", address="", code="", problem=problem))
        return
    try:
        server = StudentServer(listening, files_of(site), code, Folder(folder), say)
    except FolderError as error:
        say(Serving(type="serving", address="", code="", problem=str(error)))
        return
    say(Serving(type="serving", address=server.address, code=server.code, problem=""))
    loop, serving = asyncio.get_running_loop(), asyncio.ensure_future(server.serve())

    def listen() -> None:
        for line in sys.stdin.buffer:
            message: Remove = json.loads(line)
            loop.call_soon_threadsafe(server.remove, message["numbers"])
        loop.call_soon_threadsafe(serving.cancel)

    threading.Thread(target=listen, daemon=True).start()
    with suppress(asyncio.CancelledError):
        await serving


if __name__ == "__main__":
    asyncio.run(_serve(Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], int(sys.argv[4])))
