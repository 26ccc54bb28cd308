"""A stage with the simulator in the process of its parent, for a system without processes and threads."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterable
from typing import cast

from improv_core.ipc.arrivals import End
from improv_core.ipc.stage_process import HearStage
from improv_core.page.broadcast import Broadcast
from improv_core.plain import one_line
from improv_core.protocol.decoding import dumps
from improv_core.protocol.messages import VERSION, FromStage, Ready, ToStage
from improv_core.protocol.output import Sink
from improv_core.protocol.page_messages import ForPages
from improv_core.safety.heartbeat import Parent
from improv_core.safety.stops import Stops
from improv_core.score.score_json import RowsRead
from improv_core.stage.loop import Loop, OpenedOutput
from improv_core.stage.stdio import arrival


class InProcessStage:
    """A stage as `Playback` uses it. The event loop handles all messages to it and from it in turn."""

    def __init__(self, sink: Sink, broadcast: Broadcast, hear: HearStage, stops: Stops) -> None:
        self._broadcast, self._hear, self._stops = broadcast, hear, stops
        self._events = asyncio.get_running_loop()
        self._read = RowsRead()
        self._closed = False
        self._timer: asyncio.TimerHandle | None = None
        self._play = Loop(OpenedOutput(sink, self._report, broadcast.show), _Clock(), Parent())
        self.ready: Ready = {"type": "ready", "protocol": VERSION, "sink": sink.name, "real": False, "page": ""}

    @property
    def plays(self) -> bool:
        """True while robots move, or wait for beat 0."""
        return self._play.player.run.mode in ("playing", "waiting")

    def tell(self, message: FromStage) -> None:
        """Send the parent a message, such as a page's request."""
        asked = self._stops.arrive(message["command"]) if message["type"] == "request" else 0
        self._events.call_soon(self._told, message, asked)

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return nothing: it has no real robots."""
        return []

    def send(self, message: ToStage) -> None:
        if message["type"] == "page":
            self._broadcast.publish(cast(ForPages, message["message"]))
            return
        said = arrival(dumps(message), self._read)
        assert not isinstance(said, End)
        self._do(lambda: self._play.take(said, time.monotonic()))

    async def close(self) -> None:
        self._closed = True
        if self._timer:
            self._timer.cancel()

    def _report(self, message: FromStage) -> None:
        self._broadcast.report(message)
        self.tell(message)

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
