"""A stage with the simulator in the process of its parent, for a system without processes and threads."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterable
from typing import cast

from improv_core.ipc.arrivals import End
from improv_core.ipc.stage_process import Heard
from improv_core.plain import one_line
from improv_core.protocol.messages import VERSION, FromStage, Ready, ToStage
from improv_core.protocol.page_messages import ForPages
from improv_core.protocol.sliced_json import dumps
from improv_core.safety.parent_heartbeat import Parent
from improv_core.safety.stops import Stops
from improv_core.score.score_json import RowsRead
from improv_core.stage.loop import Loop, OpenedOutput
from improv_core.stage.stdio import arrival

Hear = Callable[["InProcessStage", Heard, int], None]


class InProcessStage:
    """A stage as `Playback` uses it. The event loop handles all messages to it and from it in turn.

    `open_sink` gets the function by which the stage sends its parent messages, and `hand_to_pages` messages for pages.
    """

    def __init__(
        self,
        open_sink: Callable[[Callable[[FromStage], None]], OpenedOutput],
        hand_to_pages: Callable[[ForPages], None],
        hear: Hear,
        stops: Stops,
    ) -> None:
        self._hand_to_pages, self._hear, self._stops = hand_to_pages, hear, stops
        self._events = asyncio.get_running_loop()
        self._read = RowsRead()
        self._closed = False
        self._timer: asyncio.TimerHandle | None = None
        opened = open_sink(self.tell)
        self._play = Loop(opened, _Clock(), Parent())
        self.ready: Ready = {"type": "ready", "protocol": VERSION, "sink": opened.sink.name, "real": False, "page": ""}

    def tell(self, message: FromStage) -> None:
        """Send the parent a message, such as a page's request."""
        asked = self._stops.arrive(message["command"]) if message["type"] == "request" else 0
        self._events.call_soon(self._told, message, asked)

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return nothing: it has no real robots."""
        return []

    def send(self, message: ToStage) -> None:
        if message["type"] == "page":
            self._hand_to_pages(cast(ForPages, message["message"]))
            return
        said = arrival(dumps(message), self._read)
        assert not isinstance(said, End)
        self._do(lambda: self._play.take(said, time.monotonic()))

    async def close(self) -> None:
        self._closed = True
        if self._timer:
            self._timer.cancel()

    def _told(self, message: FromStage, asked: int) -> None:
        if not self._closed:
            self._hear(self, message, asked)

    def _do(self, work: Callable[[], None]) -> None:
        """Do some work, then everything that is due, and wake up for the next thing."""
        if self._closed:
            return
        try:
            work()
        except Exception as error:
            self._closed = True
            self._hear(self, {"type": "gone", "message": one_line(error)}, 0)
            return
        if self._timer:
            self._timer.cancel()
        now = time.monotonic()
        if (due := self._play.deadline(now)) < math.inf:
            self._timer = self._events.call_later(max(due - now, 0.0), self._do, self._advance)

    def _advance(self) -> None:
        self._play.advance(time.monotonic())


class _Clock:
    now = staticmethod(time.monotonic)
    wall = staticmethod(time.time)

    def asleep(self) -> float:
        return 0.0

    def wait_until(self, now: float) -> None:
        """Do nothing: the event loop waits."""
