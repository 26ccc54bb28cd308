"""The page's server, on a thread of its own."""

from __future__ import annotations

import asyncio
import atexit
import json
import secrets
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from improv_core.score.score import Score
from improv_core.stage.commands import PageRequest, Stop, Watched
from improv_core.stage.messages import Decided, Sensed, Stopped, ToPages, TransportMessage
from improv_core.stage.viewer.answers import Answers
from improv_core.stage.viewer.application import HOST, Application
from improv_core.stage.viewer.lookahead import about
from improv_core.stage.viewer.meetings import Meetings
from improv_core.stage.viewer.messages import MeetingsMessage, ShownScore
from improv_core.stage.viewer.pages import Pages

if TYPE_CHECKING:
    from improv_core.stage.sinks.simulator import Snapshot


class Viewer:
    """The page's server, on this machine's loopback address only.

    `snapshot` is called 60 times a second while a page is open, and `command` with each command from a page (and with
    `WATCHED` when one is opened), both from the server's thread: they must return at once. With `takes_start_poses`,
    one of them may be `place`. `tell` gets a line if robots will meet because of a score that has taken over. A page
    survives a new server if that has the same `port` and `token`.
    Raises OSError if the port is taken; port 0 is any free one.
    """

    def __init__(
        self,
        port: int,
        snapshot: Callable[[], Snapshot],
        command: Callable[[PageRequest | Watched], None],
        *,
        takes_start_poses: bool = False,
        token: str | None = None,
        tell: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._takes_start_poses = takes_start_poses
        self._token = token or secrets.token_urlsafe()
        self._socket = socket.create_server((HOST, port))
        self._port: int = self._socket.getsockname()[1]
        self._pages = Pages(snapshot)
        self._answers = Answers()
        self._meetings = Meetings(self.publish, tell)
        self._restarted = 0
        self._stop = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        self._application = Application(self._token, self._pages, self._answers, command)
        self._thread = threading.Thread(target=self._run, name="improv-viewer", daemon=True)
        self._thread.start()
        atexit.register(self.close)  # a page should know whether a performance is over or was cut off

    @property
    def address(self) -> str:
        """The page's address. It takes a ticket to open the page there."""
        return f"http://{HOST}:{self._port}/"

    def publish(
        self,
        message: TransportMessage | Stopped | ToPages | Stop | ShownScore | MeetingsMessage | Sensed | Decided,
    ) -> None:
        """Send a message to every page, and to later ones until another of its type, about the same, replaces it.

        An answer goes to the page that has asked, and a stop that was obeyed to the one that asked for it.
        """
        if message["type"] == "stop":
            self._soon(self._application.confirm, message["mark"])
            return
        if message["type"] == "answer":
            answer = message["answer"]
            self._soon(self._pages.answer, message["page"], answer["type"], json.dumps(answer))
            return
        if message["type"] == "measured":
            self._soon(self._pages.measure, message)
            return
        if message["type"] == "transport" and message["restarted"] != self._restarted:
            self._restarted = message["restarted"]
            self._soon(self._pages.forget_measured)
        if message["type"] == "transport" or message["type"] == "sensed":
            self._answers.take(message)
        kind = [str(message["type"])]
        if message["type"] == "sensed":
            kind += message["robot"], message["sense"]
        elif message["type"] == "fault":
            kind += message["robot"], message["fault"]
        elif message["type"] == "decided":
            kind += [message["robot"]]
        self._soon(self._pages.put, " ".join(kind), json.dumps(message))

    def show(self, score: Score, generation: int) -> None:
        """Show what will be played, once the player's messages have this generation."""
        self._answers.show(score, generation)
        self.publish(about(score, generation, takes_start_poses=self._takes_start_poses))
        self._meetings.show(score, generation)

    def close(self) -> None:
        """Send what has been published, then end all connections and the thread."""
        atexit.unregister(self.close)
        self._soon(self._stop.set)
        self._answers.close()
        self._meetings.close()
        self._thread.join()

    def _soon(self, what: Callable[..., None], *values: object) -> None:
        """Have the server's thread do something."""
        with suppress(RuntimeError):  # already closed
            self._loop.call_soon_threadsafe(what, *values)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._serve())
        finally:
            self._loop.close()

    async def _serve(self) -> None:
        watching = asyncio.create_task(self._pages.watch())
        try:
            await self._application.serve(self._socket, self._stop)
        finally:
            watching.cancel()
