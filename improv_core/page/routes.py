"""The page over HTTP and its WebSocket. It imports aiohttp, which takes long, so import it only when it is needed."""

from __future__ import annotations

import asyncio
import re
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from mimetypes import guess_type
from pathlib import Path
from typing import TYPE_CHECKING

from aiohttp import web

from improv_core.ipc.rate_limit import Throttle
from improv_core.page.connection import PageConnection
from improv_core.page.files import FOLDER
from improv_core.page.own_machine import HOST
from improv_core.page.song_file import serve
from improv_core.page.web_server import HEADERS, Access, abort, add_files, receive, serving
from improv_core.protocol.commands import PageOpened, PageRequest, Stop
from improv_core.protocol.editing import MAX_PAGES
from improv_core.safety.stage_stops import stop_stages

if TYPE_CHECKING:
    import socket

    from improv_core.page.answers import Answers
    from improv_core.page.open_pages import Pages
    from improv_core.page.outbox import PageOutbox
    from improv_core.page.stop_confirmations import PageStops
    from improv_core.score.music import Music

PARTING = 0.25
"""Seconds that pages have at the end to receive the reason."""
MAX_BYTES = 1024 * 1024
"""Bytes of a message from a page: enough for the longest text, in any JSON encoding."""
CONFIRM_LIMIT = 1.0
"""Seconds for which a stop may wait for its confirmation. Then the page learns that the stop has only arrived."""
ASK_LIMIT = 0.8
"""Seconds for which stages may let a stop wait for their own confirmation: less, so that the answer has their names."""
HEAD_START = 0.02
"""Seconds that stages have to obey a stop that has gone straight to them: too few to notice."""
MAX_ASKING = 16
"""The most stops whose confirmation by stages is awaited at the same time."""
_PAGE, _NUMBER = re.compile(r"[0-9A-Za-z-]{1,64}"), re.compile(r"[0-9]{1,15}")
"""The name that a page gives itself, and the number of a stop."""
NO_TOKEN = '<meta id="token" name="improv-token" content="">'
"""The tag in index.html that the token replaces."""

# Only VS Code shows the page in a frame. Every frame around the page has to be among these. On a desktop, these are the
# window (vscode-file:) and the webview (vscode-webview:). In a browser, it is code-server or `code serve-web` on this
# machine, on any port, and webviews from VS Code's CDN, where each has its own host. Any other server on this machine
# may frame the page, too, but without a ticket: then the page has no token, because in a frame it uses only a token
# from a ticket that this very load has redeemed.
FRAMES = f"http://{HOST}:* http://localhost:* vscode-file: vscode-webview: https://*.vscode-cdn.net"
CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    f"img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors {FRAMES}"
)


class Application:
    """Serves the page on a socket: with the token if the URL has a valid ticket. Every request except for the page's
    files, the tutorial, and the dances to begin with needs the token.

    `command` gets each command from a page, and `watched` when a page is opened, or closed in a frame. `music` returns
    the song that plays. A stop also goes straight to the stages of the `show`, if their sockets are known.
    """

    def __init__(
        self,
        access: Access,
        pages: Pages,
        answers: Answers,
        stops: PageStops,
        command: Callable[[PageRequest | PageOpened], None],
        music: Callable[[], Music | None],
        show: Path | None = None,
    ) -> None:
        self._show = show
        self._asking = 0  # the number of stops whose confirmation by stages is awaited
        self._access = access
        self._pages = pages
        self._answers = answers
        self._stops = stops
        self._command = command
        self._music = music
        self._throttle = Throttle(command, lambda delay, do: asyncio.get_running_loop().call_later(delay, do))
        self._open: dict[PageOutbox, web.Request] = {}
        self._index = (FOLDER / "index.html").read_text(encoding="utf-8")
        assert self._index.count(NO_TOKEN) == 1

    async def serve(self, listening: socket.socket, stop: asyncio.Event) -> None:
        """Serve until `stop` is set. Then send the messages that wait for pages, and disconnect the pages."""
        application = web.Application()
        application.router.add_get("/", self._show_page)
        application.router.add_get("/token", self._accept_token)
        application.router.add_get("/path.svg", self._show_path)
        application.router.add_get("/song", self._play_song)
        application.router.add_get("/time", self._tell_time)
        application.router.add_get("/examples.json", self._show_examples)
        for path in ("/guide.json", "/images/{name:.+}"):
            application.router.add_get(path, self._show_guide)
        application.router.add_get("/live", self._live)
        application.router.add_post("/stop", self._stop)
        add_files(application, FOLDER)
        headers = {**HEADERS, "Content-Security-Policy": CONTENT_POLICY}
        async with serving(application, listening, headers, end_limit=1.0) as accepting:
            await stop.wait()
            accepting.cancel()
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._pages.emptied(), PARTING)
            for request in self._open.values():
                abort(request)  # closing politely would wait for pages that no longer listen

    async def _show_page(self, request: web.Request) -> web.Response:
        token = escape(self._access.open(request))
        page = self._index.replace(NO_TOKEN, NO_TOKEN.replace('""', f'"{token}"'))
        return web.Response(text=page, content_type="text/html", charset="utf-8")

    async def _accept_token(self, request: web.Request) -> web.Response:
        """Check the page's token, because browsers hide from a page why its WebSocket was refused."""
        self._access.check(request)
        return web.Response(status=204)

    async def _show_path(self, request: web.Request) -> web.Response:
        self._access.check(request)
        picture = await self._answers.compute(self._answers.picture)
        if picture is None:
            raise web.HTTPNotFound
        return web.Response(text=picture, content_type="image/svg+xml")

    async def _show_examples(self, request: web.Request) -> web.Response:
        """Return the dances that need no `improv.toml`: the program on the page has its own."""
        from improv_core.page.gallery import examples  # no page needs them at first

        found = await self._answers.compute(partial(examples, alone=True))
        return web.Response(body=found, content_type="application/json")

    async def _show_guide(self, request: web.Request) -> web.Response:
        """Return the tutorial or one of its pictures. All are read at once: no path ever comes from a URL."""
        from improv_core.page.gallery import guide_files

        name = request.path.removeprefix("/")
        found = guide_files().get(name)
        if found is None:
            raise web.HTTPNotFound
        return web.Response(body=found, content_type=guess_type(name)[0] or "application/json")

    async def _play_song(self, request: web.Request) -> web.StreamResponse:
        self._access.check(request)
        return await serve(request, self._music())

    async def _tell_time(self, request: web.Request) -> web.Response:
        """Return the server's Unix time, for a page that needs it more exactly than its first message gave it."""
        self._access.check(request)
        return web.Response(text=repr(time.time()))

    async def _stop(self, request: web.Request) -> web.Response:
        """Take a stop over its own connection: 204 once all have obeyed it, else 202 with the names of the others, if
        known."""
        self._access.check(request, needs_origin=True)
        page, given = _page_of(request), request.query.get("number", "")
        if not page or not _NUMBER.fullmatch(given):
            raise web.HTTPBadRequest
        number = int(given)
        if self._stops.arrive(page, number):
            self._pass_stop(page, number)
        elif not self._stops.is_confirmed(page, number):
            # Another stage may have taken over the robots of one that has died.
            self._ask_stages(self._stop_of(page, number))
        if await self._stops.confirmed(page, number, CONFIRM_LIMIT):
            return web.Response(status=204)
        return web.Response(status=202, text=self._stops.waits_for(page))

    def _pass_stop(self, page: str, number: int) -> None:
        """Send a stop straight to all stages. Each reports it to the session, which gets it from here only if they have
        not all obeyed soon: its work must not delay theirs."""
        stop = self._stop_of(page, number)

        def tell_session() -> None:
            if not self._stops.is_confirmed(page, number):
                self._throttle.take(stop)

        if self._ask_stages(stop):
            asyncio.get_running_loop().call_later(HEAD_START, tell_session)
        else:
            tell_session()

    def _stop_of(self, page: str, number: int) -> Stop:
        return {"type": "stop", "direct": f"{page} {number}", "at": time.monotonic()}

    def _ask_stages(self, stop: Stop) -> bool:
        """Send a stop straight to all stages, on a thread: one that is halted must not delay the next stop. Return
        whether they are being asked."""
        if self._show is None or self._asking >= MAX_ASKING:
            return False
        loop, show = asyncio.get_running_loop(), self._show

        def ask() -> None:
            waits_for = stop_stages(show, stop, ASK_LIMIT)
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(heard, waits_for)

        def heard(waits_for: Sequence[str] | None) -> None:
            self._asking -= 1
            if waits_for is not None:
                self._stops.obeyed(stop["direct"], waits_for)

        try:
            threading.Thread(target=ask, daemon=True).start()
        except RuntimeError:  # there can't be more threads now
            return False
        self._asking += 1
        return True

    async def _live(self, request: web.Request) -> web.WebSocketResponse:
        self._access.check(request, needs_origin=True)
        if len(self._pages) >= MAX_PAGES:
            raise web.HTTPServiceUnavailable
        # Nothing is buffered beyond what the system takes, so that a slow page sees the present.
        page = web.WebSocketResponse(heartbeat=20, compress=False, max_msg_size=MAX_BYTES, writer_limit=0)
        outbox = self._pages.join()
        self._open[outbox] = request
        name, framed = _page_of(request), "framed" in request.query
        stop = partial(self._pass_stop, name)
        connection = PageConnection(name, outbox, self._answers, self._stops, stop, self._throttle.take)
        sending: asyncio.Task[None] | None = None
        try:
            await page.prepare(request)
            sending = asyncio.create_task(connection.send_by(page.send_str))
            self._command(self._watched(framed))
            await receive(page, request, connection.receive)
        finally:
            if sending:
                sending.cancel()
            del self._open[outbox]
            self._pages.leave(outbox)
            if framed:
                self._command(self._watched(framed))
        return page

    def _watched(self, framed: bool) -> PageOpened:
        count = sum("framed" in request.query for request in self._open.values())
        return {"type": "page_opened", "framed": count} if framed else {"type": "page_opened"}


def _page_of(request: web.Request) -> str:
    """Return the name of the page that asks; empty if it gives none."""
    page = request.query.get("page", "")
    return page if _PAGE.fullmatch(page) else ""
