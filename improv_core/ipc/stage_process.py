"""The parent's side of a stage: starts the process, exchanges messages, and watches it. Standard library only."""

from __future__ import annotations

import asyncio
import json
import math
import os
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any, Literal, Protocol, TypedDict

from improv_core import LineError
from improv_core.ipc.arrivals import UrgentQueue
from improv_core.ipc.child import Child, Policy
from improv_core.protocol.commands import Stop, is_stop, starts
from improv_core.protocol.decoding import ProtocolError, dumps, read_as
from improv_core.protocol.limits import END_LIMIT, STOP_PIPE
from improv_core.protocol.messages import FromStage, Ready, ToStage
from improv_core.protocol.transport import may_move
from improv_core.safety.heartbeat import LOOK_PERIOD, PING_PERIOD, StageWatchdog
from improv_core.safety.stops import MAX_DIRECT, Stops

SHORT = 500
"""The movements that a score may bring and still be written at once: longer ones would hold up stops."""
START_LIMIT = 60.0
"""Seconds a stage may take until it is ready, on a busy machine."""
POLICY = Policy(END_LIMIT, leads=True, errors=subprocess.PIPE)
"""Ctrl-Z must not suspend a stage too, or robots would keep moving. If a stage is killed, only its standby survives."""


class Gone(TypedDict):
    """Reports that a stage exited by itself or was killed because it hung. Its parent makes this message."""

    type: Literal["gone"]
    message: str


Heard = FromStage | Gone
"""The messages from a stage, and its end."""


class RunningStage(Protocol):
    """The part of `Stage` that a playback uses."""

    @property
    def ready(self) -> Ready: ...

    def send(self, message: ToStage) -> None: ...

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return which of these robots move, by the latest report. Callable from any thread."""

    async def close(self) -> None: ...


HearStage = Callable[[RunningStage, Heard, int], None]
"""Gets the messages from a stage. A request from a page comes with the count of stops at its arrival."""


class StageError(LineError):
    """A stage can't be started. The message is one line with the advice."""


class Stage:
    """A stage process. Made by `start`.

    A thread reads, so an event loop that is busy is not mistaken for a dead stage. Another one writes what would keep
    the caller waiting: long scores, and everything while the stage does not read.
    Stops, pauses, and pings have a channel of their own, `stops_by`: a pipe that never holds a long message. On
    Windows, a child process can't inherit one, so they go to standard input, behind the message that is being written
    there.
    """

    ready: Ready
    """Its first message."""

    def __init__(self, child: Child, hear: HearStage, stops: Stops, stops_by: int | None) -> None:
        self._child = child
        self._hear = hear
        self._stops = stops
        self._loop = asyncio.get_running_loop()
        self._closing = False
        self._hung = self._failure = ""
        self._first: asyncio.Future[Heard] = self._loop.create_future()
        self._ended = asyncio.Event()
        self._outbox: UrgentQueue[ToStage | bytes | None] = UrgentQueue()
        self._behind = 0  # the number of items in there that have yet to be written
        self._sending = threading.Lock()
        self._sent: deque[str] = deque(maxlen=MAX_DIRECT)  # stops that it was sent, which may also come straight to it
        # Stops that have come straight to it, and were not sent to it.
        self._reported: deque[Stop] = deque(maxlen=MAX_DIRECT)
        self._stops_by = stops_by
        self._number = 0  # the latest number that was used
        self._before = 0  # the number of the latest message on that channel
        self._pinged = -math.inf  # the time of the latest ping there
        self._awake = threading.Event()  # the stage may no longer rest
        self._over = threading.Event()  # it has ended, or is about to
        self._watch = StageWatchdog(time.monotonic())
        self._looking = True  # true once it is ready
        self._moves = False  # by the reader: true if it moved in its latest report
        for work in (self._write, self._keep_pinging, self._read):
            threading.Thread(target=work, daemon=True).start()

    @classmethod
    async def start(cls, command: Sequence[str], env: Mapping[str, str], hear: HearStage, stops: Stops) -> Stage:
        """Start a stage and wait until it is ready. `stops` obeys its pages. Raises StageError with the stage's
        message.

        A stage that doesn't answer for too long is killed (`StageWatchdog`).
        """
        try:
            child, stops_by = _start(command, env)
        except OSError as error:
            raise StageError(f"{command[0]} can't be started: {error.strerror}") from None
        stage = cls(child, hear, stops, stops_by)
        try:
            first = await asyncio.wait_for(asyncio.shield(stage._first), START_LIMIT)
        except asyncio.TimeoutError:
            first = {"type": "error", "message": "the stage did not start in time: try again"}
        except asyncio.CancelledError:
            child.kill()
            raise
        if first["type"] != "ready":
            await stage.close()
            raise StageError(
                first["message"]
                if first["type"] in ("error", "gone")
                else f"the stage sent an unexpected first message: {first['type']}"
            )
        stage.ready = first
        stage._look()
        return stage

    @property
    def pid(self) -> int:
        return self._child.pid

    @property
    def alive(self) -> bool:
        return not self._ended.is_set() and not self._closing

    @property
    def _kind(self) -> str:
        """The word for it, for people: the process of a page alone moves nothing."""
        ready = self._first.result() if self._first.done() else None
        return "page" if ready and ready["type"] == "ready" and ready["sink"] == "page" else "stage"

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return which of these robots move, by the latest report. Callable from any thread."""
        return [*robots] if self._moves else []

    def send(self, message: ToStage) -> None:
        """Send a message. A message to a dead stage is lost; its end has been reported."""
        self._watch.writing(time.monotonic())
        self._awake.set()
        with self._sending:
            if message["type"] == "stop" and "direct" in message:
                self._note_sent(message["direct"])
            if self._stops_by is not None and is_stop(message):
                self._send_first(message)
            else:
                if self._stops_by is not None:
                    if message["type"] == "load":
                        self._settle()
                    moves = message["type"] == "load" or starts(message)
                    if moves and time.monotonic() > self._pinged + PING_PERIOD:  # otherwise, one is just there
                        self._send_first({"type": "ping"})  # the stage must expect pings before it moves anything
                    numbered: Any = {**message, "after": self._before}  # any message may have this field
                    message = numbered
                self._put(message)
        if not self._looking:
            with suppress(RuntimeError):  # the loop was closed
                self._loop.call_soon_threadsafe(self._begin_to_look)

    async def close(self) -> None:
        """Close its input, which stops the robots and ends the stage, or kill it if it does not exit."""
        self._closing = True
        self._over.set()
        self._awake.set()
        self._close_channel()
        self._outbox.put(None)
        for _ in range(2):
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._ended.wait(), END_LIMIT)
                return
            self._child.kill()

    def _begin_to_look(self) -> None:
        if not self._looking:
            self._looking = True
            self._look()

    def _look(self) -> None:
        """Kill the process if it hangs. Calls itself again and again, except while the stage rests."""
        now = time.monotonic()
        limit = self._watch.look(now, self.ready["real"])
        if limit is not None and not self._closing:
            self._hung = f"the {self._kind} did not answer for {limit:g} s"
            self._child.kill()
        elif self.alive and not self._watch.rests(now):
            self._loop.call_later(LOOK_PERIOD, self._look)
        else:
            self._looking = False

    def _write(self) -> None:
        """Write to standard input what may take long."""
        with suppress(OSError):  # it has ended
            while (item := self._outbox.get()) is not None:
                self._child.write(item if isinstance(item, bytes) else _line(item))
                with self._sending:
                    self._behind -= 1
        self._close_channel()  # then nobody else writes
        self._child.close_input()

    def _put(self, message: ToStage) -> None:
        """Write a message to standard input, at once if that can't take long: a thread would first have to wait until
        the caller rests. Hold the lock."""
        messages: list[ToStage] = [message]
        if message["type"] == "load":
            self._number += 1
            self._watch.loading(self._number)
            messages.append({"type": "ping", "number": self._number})
        items: Sequence[ToStage | bytes] = messages
        is_short = message["type"] != "load" or len(message["score"].get("movements", ())) <= SHORT
        if is_short and not self._behind and self._stops_by is not None:
            rest = self._child.write_now(b"".join(json.dumps(each).encode() + b"\n" for each in messages))
            items = [rest] if rest else []
        self._behind += len(items)
        for each in items:
            self._outbox.put(each)

    def _keep_pinging(self) -> None:
        """Ping while the stage doesn't rest. This has its own thread, so that a long message can't delay a ping."""
        while not self._over.is_set():
            if self._watch.rests(time.monotonic()):
                while not self._awake.wait(PING_PERIOD):
                    self._stops.halts.runs(time.monotonic())
            self._awake.clear()
            self._stops.halts.runs(time.monotonic())
            if self._watch.may_ping(time.monotonic()):
                with self._sending:
                    if self._stops_by is not None:
                        self._send_first({"type": "ping"})
                    else:
                        self._number += 1
                        self._watch.ping(self._number)
                        self._put({"type": "ping", "number": self._number})
            self._over.wait(PING_PERIOD)
        self._stops.halts.rests()

    def _send_first(self, message: Mapping[str, Any]) -> None:
        """Send a numbered message on the channel of stops. Hold the lock."""
        assert self._stops_by is not None
        self._number = self._before = self._number + 1
        if message["type"] == "ping":
            self._pinged = time.monotonic()
            self._watch.ping(self._number)
        line = json.dumps({**message, "number": self._number}).encode() + b"\n"
        with suppress(OSError):  # it has ended; or it has read nothing for minutes, and is about to be killed
            os.write(self._stops_by, line)  # a line this short is written completely or not at all

    def _settle(self) -> None:
        """Send the stops that have come straight to the stage and went to all others before it could be sent any: until
        then, it obeys nothing. Hold the lock."""
        for stop in [each for each in self._reported if self._stops.has_settled(each["direct"])]:
            self._note_sent(stop["direct"])
            self._send_first({name: value for name, value in stop.items() if name != "at"})

    def _note_sent(self, direct: str) -> None:
        self._sent.append(direct)
        self._reported = deque((each for each in self._reported if each["direct"] != direct), MAX_DIRECT)

    def _close_channel(self) -> None:
        with self._sending:
            if self._stops_by is not None:
                os.close(self._stops_by)
                self._stops_by = None

    def _read(self) -> None:
        with suppress(EOFError):
            while True:
                for line in self._child.read():
                    with suppress(ProtocolError):
                        self._take(read_as(line, FromStage))
        self._child.wait()
        with suppress(RuntimeError):  # the loop was closed before the stage ended
            self._loop.call_soon_threadsafe(self._end)

    def _take(self, message: FromStage) -> None:
        if message["type"] == "pong":
            self._watch.pong(message["number"], time.monotonic())
            return
        if message["type"] == "transport":
            self._moves = message["state"] == "playing"
            self._watch.moving(self._moves, may_move(message), time.monotonic())
            if may_move(message):
                self._awake.set()
                with suppress(RuntimeError):
                    self._loop.call_soon_threadsafe(self._begin_to_look)
        if message["type"] == "stopped":
            self._watch.stopped(time.monotonic())
            self._moves = False
            self._failure = message.get("message", "")
        # Here and not on the event loop, which may be busy: a stop at a page has to be obeyed at once.
        stops = 0
        if message["type"] == "request":
            command = message["command"]
            if command["type"] == "stop" and "direct" in command:
                with self._sending:
                    if command["direct"] not in self._sent:
                        self._reported.append(command)
            stops = self._stops.arrive(message["command"])
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._deliver, message, stops)

    def _deliver(self, message: Heard, stops: int = 0) -> None:
        if not self._first.done():
            if message["type"] != "request":  # pages of an earlier stage may reconnect before this one is ready
                self._first.set_result(message)
        elif not (self._closing and message["type"] == "gone"):
            self._hear(self, message, stops)

    def _end(self) -> None:
        self._ended.set()
        self._over.set()
        self._awake.set()
        self._close_channel()
        self._outbox.put(None)
        why = self._failure or self._child.last_error
        ended = f"the {self._kind} failed: {why}" if why else f"the {self._kind} exited unexpectedly"
        self._deliver({"type": "gone", "message": self._hung or ended})


def _line(message: ToStage) -> bytes:
    return dumps(message) + b"\n"


def _start(command: Sequence[str], env: Mapping[str, str]) -> tuple[Child, int | None]:
    """Return the process, and our end of its channel of stops if it can have one. Raises OSError."""
    if sys.platform == "win32":
        return Child(command, POLICY, env), None
    theirs, ours = os.pipe()
    try:
        os.set_blocking(ours, False)
        return Child(command, POLICY, {**env, STOP_PIPE: str(theirs)}, pass_fds=[theirs]), ours
    except OSError:
        os.close(ours)
        raise
    finally:
        os.close(theirs)
