"""The teacher's page and its WebSocket, on this machine's loopback address only, on a thread of its own. It imports
aiohttp, which takes long, so import it only when it is needed."""

from __future__ import annotations

import asyncio
import io
import json
import secrets
import zipfile
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import segno
from aiohttp import web

from improv_core.classroom.messages import Command, FromDesk, read
from improv_core.page.files import FOLDER as PAGE_FOLDER
from improv_core.page.loop_thread import LoopThread
from improv_core.page.outbox import Audience
from improv_core.page.own_machine import HOST
from improv_core.page.web_server import HEADERS, Access, add_files, receive, serving
from improv_core.protocol.tickets import Tickets, issue

if TYPE_CHECKING:
    import socket

    from improv_core.classroom.desk import Desk

FOLDER = Path(__file__).parent / "static"
MAX_MESSAGE = 10_000
MAX_PAGES = 8
END_LIMIT = 0.05
"""Seconds that requests may take when the class ends. A page that is still open never finishes its own."""
CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)


class TeacherPage:
    """Serves the page on a socket. It calls all that it is given on the thread of its server, so a stop goes straight
    to the stages even if the event loop of `improv class` hangs.

    It shows what the `desk` has. `take` gets each command, and `stop` stops everything at once. `stage` makes a new
    address of the simulator's page, and `offer` gets a new address of this page if somebody has tried one that was
    used.
    """

    def __init__(
        self,
        listening: socket.socket,
        desk: Desk,
        take: Callable[[Command], None],
        stop: Callable[[], None],
        stage: Callable[[], str | None],
        offer: Callable[[str], None],
    ) -> None:
        self._socket, self._desk = listening, desk
        self._take, self._stop, self._stage, self._offer = take, stop, stage, offer
        self._is_offered = True  # an address in the terminal that nobody has used
        self._token = secrets.token_urlsafe()
        self._access = Access(self._token, Tickets(self._token))
        self._pages = Audience()
        self._thread = LoopThread("improv-teacher")
        self._page = ""

    def link(self) -> str:
        """Return a new URL that opens the page once."""
        return f"http://{HOST}:{self._socket.getsockname()[1]}/?ticket={issue(self._token)}"

    def publish(self, message: FromDesk) -> None:
        """Send a message to all pages, and to later ones, from any thread. About each child, the latest one counts."""
        about = str(message["number"]) if message["type"] in ("child", "gone") else message["type"]
        self._thread.soon(self._pages.put, about, json.dumps(message))

    def open(self, address: str, code: str) -> None:
        """Begin to serve the page, which shows the class's address and its code."""
        link = segno.make(f"{address}#class={code}", error="m", micro=False)
        picture = link.svg_data_uri(scale=4, border=2, light="white", omitsize=True)
        self._page = (FOLDER / "teacher.html").read_text(encoding="utf-8")
        for mark, text in (("ADDRESS", address), ("ROOM_CODE", code), ("QR_CODE", picture)):
            self._page = self._page.replace(f"{{{mark}}}", escape(text))
        self._thread.start(self._serve)

    def close(self) -> None:
        """End the server."""
        self._thread.close()

    async def _serve(self, stop: asyncio.Event) -> None:
        application = web.Application()
        application.router.add_get("/", self._show)
        application.router.add_get("/live", self._live)
        application.router.add_post("/stop", self._obey_stop)
        application.router.add_get("/stage", self._open_stage)
        application.router.add_get("/dances.zip", self._save_all)
        application.router.add_get(r"/dance/{number:\d{1,9}}/{count:\d{1,9}}", self._show_dance)
        add_files(application, FOLDER)
        add_files(application, PAGE_FOLDER, "base/")
        headers = {**HEADERS, "Content-Security-Policy": CONTENT_POLICY}
        async with serving(application, self._socket, headers, END_LIMIT):
            await stop.wait()

    async def _obey_stop(self, request: web.Request) -> web.Response:
        self._access.check(request, needs_origin=True)
        self._stop()
        return web.Response(status=204)

    async def _show(self, request: web.Request) -> web.Response:
        token = self._access.open(request)
        if token:
            self._is_offered = False
        elif "ticket" in request.query and not self._is_offered:
            self._is_offered = True
            self._offer(self.link())
        page = self._page.replace("{TOKEN}", escape(token))
        return web.Response(text=page, content_type="text/html", charset="utf-8")

    async def _open_stage(self, request: web.Request) -> web.Response:
        self._access.check(request)
        if not (link := self._stage()):
            raise web.HTTPNotFound
        raise web.HTTPSeeOther(link)

    async def _show_dance(self, request: web.Request) -> web.Response:
        self._access.check(request)
        text = self._desk.text(int(request.match_info["number"]), int(request.match_info["count"]))
        if text is None:
            raise web.HTTPNotFound
        return web.Response(text=text, content_type="text/plain", charset="utf-8")

    async def _save_all(self, request: web.Request) -> web.Response:
        self._access.check(request)
        archive = io.BytesIO()
        with zipfile.ZipFile(archive, "w") as file:  # not compressed, because a stop may arrive meanwhile
            for name, text in self._desk.files():
                file.writestr(name, text)
        return web.Response(body=archive.getvalue(), content_type="application/zip")

    async def _live(self, request: web.Request) -> web.WebSocketResponse:
        self._access.check(request, needs_origin=True)
        if len(self._pages) >= MAX_PAGES:
            raise web.HTTPServiceUnavailable
        page = web.WebSocketResponse(heartbeat=20, max_msg_size=MAX_MESSAGE, compress=False)
        await page.prepare(request)
        outbox = self._pages.join()
        telling = asyncio.create_task(outbox.empty_into(page.send_str))
        try:
            await receive(page, request, self._obey)
        finally:
            telling.cancel()
            self._pages.leave(outbox)
        return page

    def _obey(self, text: str) -> None:
        if command := read(text):
            self._take(command)
