"""A stage as its parent has it: a process that is started, fed, heard and watched. Standard library only."""

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
from typing import Literal, TypedDict

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

START_LIMIT = 60.0
"""Seconds a stage may take to say that it is ready, on a busy machine."""


class Gone(TypedDict):
    """A stage has ended by itself, or was killed because it hung: what its parent says in its place."""

    type: Literal["gone"]
    message: str


Heard = FromStage | Gone
"""What is heard of a stage."""
Hear = Callable[["Stage", Heard, int], None]
"""Gets what is heard of a stage; with a request of a page, the count of stops when it arrived."""


class StageError(Exception):
    """A stage can't be had; one plain line that says what to do."""


class Stage:
    """A stage process. Made by `start`.

    Threads speak and listen, so that neither a stage that does not read nor an event loop that is busy is mistaken for
    the other's end.
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
        self._outbox: queue.SimpleQueue[ToStage | None] = queue.SimpleQueue()
        self._watch = Watch(time.monotonic())
        for work in (self._write, self._read, self._read_log):
            threading.Thread(target=work, daemon=True).start()

    @classmethod
    async def start(cls, command: Sequence[str], env: Mapping[str, str], hear: Hear, stops: Stops) -> Stage:
        """Start a stage and wait until it is ready. `stops` obeys its pages. Raises StageError with its own reason."""
        pipe = subprocess.PIPE
        try:
            # In a session of its own: Ctrl-Z must not halt it too, or robots would go on as they were told last.
            process = subprocess.Popen(  # noqa: ASYNC220
                command, stdin=pipe, stdout=pipe, stderr=pipe, env=env, start_new_session=True
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
            raise StageError(first["message"] if first["type"] in ("error", "gone") else f"it said {first['type']}")
        stage.ready = first
        stage._look()
        return stage

    @property
    def alive(self) -> bool:
        return not self._ended.is_set() and not self._closing

    def send(self, message: ToStage) -> None:
        """Send a message; one to a stage that has died is lost, and its end has been told."""
        self._outbox.put(message)

    async def close(self) -> None:
        """Close its input, which stops the robots and ends it; one that does not end is killed."""
        self._closing = True
        self._outbox.put(None)
        try:
            await asyncio.wait_for(self._ended.wait(), END_LIMIT)
        except asyncio.TimeoutError:
            self._process.kill()
            await self._ended.wait()

    def _look(self) -> None:
        """Kill the process if it hangs; called again and again."""
        limit = self._watch.look(time.monotonic(), self.ready["real"])
        if limit is not None and not self._closing:
            self._hung = f"the stage did not answer for {limit:g} s"
            self._process.kill()
        elif self.alive:
            self._loop.call_later(LOOK_PERIOD, self._look)

    def _write(self) -> None:
        pipe = self._process.stdin
        assert pipe
        next_ping = time.monotonic() + PING_PERIOD
        with suppress(OSError):  # it has ended
            while True:
                try:
                    message = self._outbox.get(timeout=max(next_ping - time.monotonic(), 0))
                    if message is None:
                        break
                except queue.Empty:
                    now = time.monotonic()
                    next_ping = now + PING_PERIOD
                    number = self._watch.ping(now)
                    if number is None:
                        continue
                    message = {"type": "ping", "number": number}
                if message["type"] == "load":
                    self._watch.loading()
                    next_ping = time.monotonic()
                pipe.write(json.dumps(message).encode() + b"\n")
                pipe.flush()
        with suppress(OSError):
            pipe.close()

    def _read(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                # Half a line of a stage that was killed, or what some library has printed.
                with suppress(ProtocolError):
                    self._take(read_from_stage(line))
        self._process.wait()
        with suppress(RuntimeError):  # the loop has been closed before the stage ended
            self._loop.call_soon_threadsafe(self._end)

    def _take(self, message: FromStage) -> None:
        if message["type"] == "pong":
            self._watch.pong(message["number"], time.monotonic())
            return
        if message["type"] == "stopped":
            self._watch.stopped(time.monotonic())
            self._failure = message.get("message", "")
        # Here and not on the event loop, which may be busy: a stop at a page is obeyed at once.
        stops = self._stops.arrive(message["command"]) if message["type"] == "request" else 0
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._told, message, stops)

    def _told(self, message: Heard, stops: int = 0) -> None:
        if not self._first.done():
            if message["type"] != "request":  # pages of an earlier stage may be back before this one is ready
                self._first.set_result(message)
        elif not (self._closing and message["type"] == "gone"):
            self._hear(self, message, stops)

    def _end(self) -> None:
        self._ended.set()
        self._outbox.put(None)
        why = self._failure or (self._last_words[-1] if self._last_words else "")
        ended = f"the stage ended: {why}" if why else "the stage ended by itself"
        self._told({"type": "gone", "message": self._hung or ended})

    def _read_log(self) -> None:
        assert self._process.stderr
        with self._process.stderr as lines:
            for line in lines:
                self._last_words.append(line.decode(errors="replace").strip())
