"""The page's server, on its own thread."""

from __future__ import annotations

import asyncio
import atexit
import secrets
import socket
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core.page.answers import Answers
from improv_core.page.background import OwnThread
from improv_core.page.broadcast import Broadcast
from improv_core.page.loop_thread import LoopThread
from improv_core.page.meetings import Meetings
from improv_core.page.open_pages import Pages
from improv_core.page.own_machine import HOST, listen
from improv_core.page.stop_confirmations import PageStops
from improv_core.protocol.commands import PageOpened, PageRequest
from improv_core.protocol.tickets import Tickets

if TYPE_CHECKING:
    from improv_core.page.ideal_floor import IdealFloor
    from improv_core.protocol.drawn import Snapshot


class PageServer:
    """The page's server, on this machine's loopback address only.

    `snapshot` is called 60 times a second while a page is open, and `command` with each command from a page (and with
    `watched` when one is opened, or closed in a frame), both from the server's thread: they must return at once. With
    `takes_start_poses`, one of them may be `place`. `tell` gets a line if robots will meet because of a score that has
    taken over. `scores` finds out when their parts begin. Stops go straight to the stages of a `show`, too. A page
    survives a new server if that has the same `port` and `token`. Raises OSError if the port is taken; port 0 is the
    `usual_port`, or any free one.
    """

    def __init__(
        self,
        port: int,
        snapshot: Callable[[], Snapshot],
        command: Callable[[PageRequest | PageOpened], None],
        *,
        usual_port: int = 0,
        takes_start_poses: bool = False,
        token: str | None = None,
        show: Path | None = None,
        tell: Callable[[str], None] = lambda line: None,
        scores: IdealFloor | None = None,
    ) -> None:
        self._token = token or secrets.token_urlsafe()
        self._tickets = Tickets(self._token)
        self._socket = socket.create_server((HOST, port)) if port else listen(usual_port)
        self._port: int = self._socket.getsockname()[1]
        self._pages = Pages(snapshot)
        self._workers = [OwnThread("improv-answers"), OwnThread("improv-meetings")]
        self._answers = Answers(self._workers[0].do)
        self._stops = PageStops()
        self._thread = LoopThread("improv-viewer")
        self._command, self._stage_sockets = command, show
        self._broadcast = Broadcast(
            self._pages,
            self._answers,
            self._thread.soon,
            self._stops.obeyed,
            takes_start_poses=takes_start_poses,
            scores=scores,
        )
        self.publish, self.show, self.report = self._broadcast.publish, self._broadcast.show, self._broadcast.report
        self.label = self._broadcast.label
        self._meetings = self._broadcast.meetings = Meetings(self.publish, tell, self._workers[1].do)
        self._thread.start(self._serve)
        atexit.register(self.close)  # tells the page that the performance is over, not cut off

    @property
    def address(self) -> str:
        """Address of the page. It takes a ticket to open the page there."""
        return f"http://{HOST}:{self._port}/"

    def close(self) -> None:
        """Send what has been published, then end all connections and the threads."""
        atexit.unregister(self.close)
        self._meetings.close()
        for worker in self._workers:
            worker.close()
        self._thread.close()

    async def _serve(self, stop: asyncio.Event) -> None:
        await _visited(self._socket, stop)
        if stop.is_set():
            self._socket.close()
            return
        from improv_core.page.routes import Application  # only now: that takes long, and robots must not wait for it
        from improv_core.page.web_server import Access

        watching = asyncio.create_task(self._pages.watch())
        application = Application(
            Access(self._token, self._tickets),
            self._pages,
            self._answers,
            self._stops,
            self._command,
            lambda: self._broadcast.music,
            self._stage_sockets,
        )
        try:
            await application.serve(self._socket, stop)
        finally:
            watching.cancel()


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
