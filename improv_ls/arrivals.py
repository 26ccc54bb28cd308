"""Messages as they arrive from the editor: stops are obeyed and counted at once, before all messages that wait.

LSP's base protocol puts a header with its length before each message. If a header is wrong, the start of the next
message can't be found, so the server ends: a server that no longer listens could not obey a stop.
"""

from __future__ import annotations

import json
import os
import re
import select
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import NamedTuple

from lsprotocol import types

from improv_core.protocol.commands import Pause, Stop
from improv_core.safety.stops import Stops

READ_SIZE = 65_536
LONGEST_HEADER = 65_536
LOOK_PERIOD, BUSY = 0.02, 0.005
"""Seconds from the first unread input until a check that it still waits, and from that check until the event loop
counts as busy because it has not read it."""
_LENGTH = re.compile(rb"^content-length:[ \t]*(\d{1,9})[ \t]*\r?$", re.IGNORECASE | re.MULTILINE)
_HEADER_END = b"\r\n\r\n"
_STOPS: Mapping[str, Stop | Pause] = {
    "improv.stop": {"type": "stop"},
    "improv.hush": {"type": "stop"},  # the name that people's key bindings may still have
    "improv.pause": {"type": "pause"},
}


class FramingError(Exception):
    """A header that doesn't give the length of its message."""


class Frames:
    """Cuts a stream of bytes into messages, keeping an incomplete one until the rest of it comes."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._length: int | None = None

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Yield the bodies that these bytes complete. Raises FramingError after the last of them."""
        self._buffer += data
        while True:
            if self._length is None:
                end = self._buffer.find(_HEADER_END)
                if (end if end >= 0 else len(self._buffer)) > LONGEST_HEADER:
                    raise FramingError(f"no end of a header within {LONGEST_HEADER} bytes")
                if end < 0:
                    return
                length = _LENGTH.search(self._buffer, 0, end + 2)
                if not length:
                    raise FramingError("a header without a valid Content-Length")
                self._length = int(length[1])
                del self._buffer[: end + len(_HEADER_END)]
            if len(self._buffer) < self._length:
                return
            body = bytes(self._buffer[: self._length])
            del self._buffer[: self._length]
            self._length = None
            yield body


class Arrival(NamedTuple):
    """A message, and the number of stops that had come when it arrived. If it is a stop itself, it has been obeyed."""

    body: bytes
    stops: int
    is_stop: bool


class Arrivals:
    """Messages from the file descriptor that is the server's input.

    Usually the event loop reads it, because handing each message from a thread to the loop costs 44 µs. Only while the
    loop is busy, a thread reads instead (`read_while_busy`), so that a stop doesn't wait for the end of an analysis.
    """

    def __init__(self, stops: Stops, source: int) -> None:
        self._stops = stops
        self._source = source
        self._frames = Frames()
        self._reading = threading.Lock()
        self._visits = 0  # of the event loop
        self._thread_has_read = False  # read something about which the loop may have got a call
        self._waiting: deque[Arrival | None] = deque()
        self.ended = False
        self.failure: FramingError | None = None
        """The error in the input, after which nothing can be read."""

    def read(self) -> None:
        """Read the bytes that are there, or else wait for some."""
        self._visits += 1
        with self._reading:
            if self._thread_has_read:  # then there may be nothing left; if there is, the loop calls this again at once
                self._thread_has_read = False
            elif not self.ended:
                self._read()

    def take(self) -> Iterator[Arrival | None]:
        """Yield all messages that have arrived and have not been taken; after the very last one, None."""
        while self._waiting:
            yield self._waiting.popleft()

    def read_while_busy(self, tell: Callable[[], object]) -> None:
        """Read, on the calling thread, whenever the event loop is too busy to do it, and call `tell` each time."""
        neglected = -1  # the latest visit of the loop, if there was something to read after it
        while not self.ended:
            if neglected < 0:
                select.select([self._source], [], [])
                time.sleep(LOOK_PERIOD)  # the event loop wakes up too and usually reads first
            else:
                time.sleep(BUSY)
            if not self._readable():
                neglected = -1
            elif neglected != self._visits:
                neglected = self._visits
            else:
                with self._reading:
                    while neglected == self._visits and not self.ended and self._readable():
                        self._read()
                        self._thread_has_read = True
                neglected = -1
                with suppress(RuntimeError):  # the loop is closed
                    tell()

    def _read(self) -> None:
        data = os.read(self._source, READ_SIZE)
        try:
            for body in self._frames.feed(data):
                stop = _stop_in(body)
                if stop:
                    self._stops.stop(stop)
                self._waiting.append(Arrival(body, self._stops.count, stop is not None))
        except FramingError as error:
            self.failure = error
        if self.failure or not data:
            self.ended = True
            self._stops.stop()
            self._waiting.append(None)

    def _readable(self) -> bool:
        return bool(select.select([self._source], [], [], 0)[0])


def _stop_in(body: bytes) -> Stop | Pause | None:
    """Return the stop or the pause that a message asks for."""
    if b"improv." in body:
        with suppress(ValueError, LookupError, TypeError, RecursionError):  # the message's handler reports it
            message = json.loads(body)
            if message["method"] == types.WORKSPACE_EXECUTE_COMMAND:
                return _STOPS.get(message["params"]["command"])
    return None
