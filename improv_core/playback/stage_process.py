"""A stage as its parent sees it: starts the process, exchanges messages, and watches it. Standard library only."""

from __future__ import annotations

import asyncio
import json
import queue
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import IO, Literal, TypedDict

from improv_core.playback.isolation import isolated
from improv_core.playback.stops import Stops
from improv_core.playback.watch import LOOK_PERIOD, PING_PERIOD, Watch
from improv_core.stage.protocol import (
    END_LIMIT,
    FromStage,
    ProtocolError,
    Ready,
    ToStage,
    read_from_stage,
)
from improv_core.stage.urgent_queue import UrgentQueue

START_LIMIT = 60.0
"""Seconds a stage may take until it is ready, on a busy machine."""


class Gone(TypedDict):
    """Reports that a stage exited by itself or was killed because it hung. Its parent makes this message."""

    type: Literal["gone"]
    message: str


Heard = FromStage | Gone
"""What is heard from a stage."""
Hear = Callable[["Stage", Heard, int], None]
"""Gets what is heard from a stage. With a request of a page comes the count of stops when it arrived."""


class _Wake:
    """Makes the thread that writes check again whether the stage rests."""


class StageError(Exception):
    """A stage can't be started. The message is one line that says what to do."""


class Stage:
    """A stage process. Made by `start`.

    Threads read and write, so a stage that does not read or an event loop that is busy is not mistaken for a dead one.
    """

    ready: Ready
    """Its first message."""

    def __init__(self, process: subprocess.Popen[bytes], hear: Hear, stops: Stops) -> None:
        self._process = process
        self._hear = hear
        self._stops = stops
        self._loop = asyncio.get_running_loop()
        self._closing = False
        self._hung = self._failure = ""
        self._first: asyncio.Future[Heard] = self._loop.create_future()
        self._ended = asyncio.Event()
        self._last_words: deque[str] = deque(maxlen=5)
        self._outbox: UrgentQueue[ToStage | _Wake | None] = UrgentQueue()
        self._watch = Watch(time.monotonic())
        self._looking = True  # once it is ready
        for work in (self._write, self._read, self._read_log):
            threading.Thread(target=work, daemon=True).start()

    @classmethod
    async def start(cls, command: Sequence[str], env: Mapping[str, str], hear: Hear, stops: Stops) -> Stage:
        """Start a stage and wait until it is ready. `stops` obeys its pages. Raises StageError with its message."""
        pipe = subprocess.PIPE
        try:
            # In a session of its own: Ctrl-Z must not suspend it too, or robots would keep moving.
            process = subprocess.Popen(  # noqa: ASYNC220
                command, stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True, **isolated(env)
            )
        except OSError as error:
            raise StageError(f"{command[0]} can't be started: {error.strerror}") from None
        stage = cls(process, hear, stops)
        try:
            first = await asyncio.wait_for(asyncio.shield(stage._first), START_LIMIT)
        except asyncio.TimeoutError:
            first = {"type": "error", "message": "the stage did not start in time: try again"}
        except asyncio.CancelledError:
            process.kill()
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
    def alive(self) -> bool:
        return not self._ended.is_set() and not self._closing

    def send(self, message: ToStage) -> None:
        """Send a message. A message to a dead stage is lost; its end has been reported."""
        self._outbox.put(message)
        if not self._looking:
            with suppress(RuntimeError):  # the loop was closed
                self._loop.call_soon_threadsafe(self._begin_to_look)

    async def close(self) -> None:
        """Close its input, which stops the robots and ends the stage. If it does not exit, it is killed."""
        self._closing = True
        self._outbox.put(None)
        try:
            await asyncio.wait_for(self._ended.wait(), END_LIMIT)
        except asyncio.TimeoutError:
            self._process.kill()
            await self._ended.wait()

    def _begin_to_look(self) -> None:
        if not self._looking:
            self._looking = True
            self._look()

    def _look(self) -> None:
        """Kill the process if it hangs. Calls itself periodically, except while the stage rests."""
        now = time.monotonic()
        limit = self._watch.look(now, self.ready["real"])
        if limit is not None and not self._closing:
            self._hung = f"the stage did not answer for {limit:g} s"
            self._process.kill()
        elif self.alive and not self._watch.rests(now):
            self._loop.call_later(LOOK_PERIOD, self._look)
        else:
            self._looking = False

    def _write(self) -> None:
        """Write messages, and pings between them. While the stage rests, only wait."""
        pipe = self._process.stdin
        assert pipe
        next_ping = time.monotonic() + PING_PERIOD
        with suppress(OSError):  # it has ended
            while True:
                now = time.monotonic()
                rests = self._watch.rests(now)
                if not rests and now >= next_ping:  # whatever else waits
                    next_ping = now + PING_PERIOD
                    self._ping(pipe)
                try:
                    message = self._outbox.get(timeout=None if rests else max(next_ping - time.monotonic(), 0))
                except queue.Empty:
                    continue
                if message is None:
                    break
                self._watch.writing(time.monotonic())
                if rests:  # first, so that the stage expects pings before it moves anything
                    self._ping(pipe)
                if isinstance(message, _Wake):
                    continue
                if message["type"] == "load":
                    self._watch.loading()
                    next_ping = time.monotonic()
                _write_line(pipe, message)
        with suppress(OSError):
            pipe.close()

    def _ping(self, pipe: IO[bytes]) -> None:
        if number := self._watch.ping(time.monotonic()):
            _write_line(pipe, {"type": "ping", "number": number})

    def _read(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                # Ignore half a line from a killed stage, or what some library printed.
                with suppress(ProtocolError):
                    self._take(read_from_stage(line))
        self._process.wait()
        with suppress(RuntimeError):  # the loop was closed before the stage ended
            self._loop.call_soon_threadsafe(self._end)

    def _take(self, message: FromStage) -> None:
        if message["type"] == "pong":
            self._watch.pong(message["number"], time.monotonic())
            return
        if message["type"] == "transport":
            plays = message["state"] == "playing"
            may_play = message["state"] == "waiting" or bool(message.get("waits_for"))
            self._watch.moving(plays, may_play, time.monotonic())
            if plays or may_play:
                self._outbox.put(_Wake())
                with suppress(RuntimeError):
                    self._loop.call_soon_threadsafe(self._begin_to_look)
        if message["type"] == "stopped":
            self._watch.stopped(time.monotonic())
            self._failure = message.get("message", "")
        # Here and not on the event loop, which may be busy: a stop at a page is obeyed at once.
        stops = self._stops.arrive(message["command"]) if message["type"] == "request" else 0
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._told, message, stops)

    def _told(self, message: Heard, stops: int = 0) -> None:
        if not self._first.done():
            if message["type"] != "request":  # pages of an earlier stage may reconnect before this one is ready
                self._first.set_result(message)
        elif not (self._closing and message["type"] == "gone"):
            self._hear(self, message, stops)

    def _end(self) -> None:
        self._ended.set()
        self._outbox.put(None)
        why = self._failure or (self._last_words[-1] if self._last_words else "")
        ended = f"the stage failed: {why}" if why else "the stage exited unexpectedly"
        self._told({"type": "gone", "message": self._hung or ended})

    def _read_log(self) -> None:
        assert self._process.stderr
        with self._process.stderr as lines:
            for line in lines:
                self._last_words.append(line.decode(errors="replace").strip())


def _write_line(pipe: IO[bytes], message: ToStage) -> None:
    pipe.write(json.dumps(message).encode() + b"\n")
    pipe.flush()
