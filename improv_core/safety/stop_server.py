"""Both ends of a stop socket: the server that hears stops, and the request that asks many servers at once.

Neither a process that connects and stays silent nor a flood of them delays a stop, and one that hangs delays no other.
"""

from __future__ import annotations

import json
import secrets
import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import cast

from improv_core.protocol.commands import Stop
from improv_core.protocol.decoding import ProtocolError, read_as

ASK = b"stop\n"
"""The line with which a request begins. One line of JSON about the stop may follow, in the same packet."""
MOST_BYTES = 1_000
"""The longest request, and the most bytes of an answer to read at once. More of a request is not read."""
READ_LIMIT = 2.0
"""Seconds for which a connection may stay silent."""
MOST_SILENT = 128
"""The most connections that may be silent at a time. One more closes the oldest, unless its request has arrived."""
AGAIN = 0.05
"""Seconds until the next try if the system had no file handle for a new connection."""
BUSY_LIMIT, BUSY_PERIOD = 0.05, 0.001
"""Seconds for which to ask a server again that takes no more connections, as in a flood, and seconds between two
tries."""

Answer = Callable[[str], None]
"""Sends the answer, and closes the connection. Callable on any thread."""
Take = Callable[[Stop, Answer], None]
"""Obeys a stop, which has an identity (`direct`). Called on threads."""


class StopServer:
    """Listens at a path that only this user can use, until it is closed. Raises OSError, also for a path that is too
    long, and RuntimeError if there can't be more threads."""

    def __init__(self, path: Path, take: Take) -> None:
        self._path = path
        self._take = take
        self._closed = threading.Event()
        self._silent: deque[socket.socket] = deque(maxlen=MOST_SILENT)
        self._server = socket.socket(socket.AF_UNIX)
        draft = path.with_suffix(".new")
        try:
            self._server.bind(str(draft))
            draft.chmod(0o600)
            self._server.listen()
            threading.Thread(target=self._serve, daemon=True).start()
            draft.rename(path)  # whoever asks removes a socket that nobody listens on, as this one was until now
        except (OSError, RuntimeError):
            self._closed.set()
            self._server.close()
            with suppress(OSError):
                draft.unlink(missing_ok=True)
            raise

    def close(self) -> None:
        self._closed.set()
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):
            self._server.shutdown(socket.SHUT_RDWR)  # wakes the thread
        self._server.close()

    def _serve(self) -> None:
        while not self._closed.is_set():
            try:
                asking, _ = self._server.accept()
            except OSError:  # closed; or the system has no file handles left for now
                self._closed.wait(AGAIN)
                continue
            if len(self._silent) == MOST_SILENT:
                with suppress(OSError, IndexError):  # it has spoken meanwhile
                    self._silent[0].shutdown(socket.SHUT_RD)  # what has arrived can still be read
            self._silent.append(asking)
            try:
                # On a thread of its own: a process that connects and stays silent must not delay the next one.
                threading.Thread(target=self._answer, args=(asking,), daemon=True).start()
            except RuntimeError:  # there can't be more threads now
                self._answer(asking)

    def _answer(self, asking: socket.socket) -> None:
        said = b""
        with suppress(OSError):
            asking.settimeout(READ_LIMIT)
            said = asking.recv(MOST_BYTES)
        with suppress(ValueError, IndexError):  # later ones have replaced it
            self._silent.remove(asking)
        if said.startswith(ASK):
            self._take(_read(said[len(ASK) :]), partial(_send, asking))
        else:
            asking.close()


class StopRequest:
    """A stop that servers are asked for, all at the same time."""

    def __init__(self, stop: Stop) -> None:
        self._line = ASK + json.dumps(stop).encode() + b"\n"
        self._asked: dict[int, tuple[Path, socket.socket]] = {}  # by the number of the connection

    def __enter__(self) -> StopRequest:
        return self

    def __exit__(self, *_: object) -> None:
        for _path, connection in self._asked.values():
            connection.close()

    def ask(self, path: Path) -> bool:
        """Ask the server at a path. Returns False if none listens there."""
        end = time.monotonic() + BUSY_LIMIT
        while True:
            connection = socket.socket(socket.AF_UNIX)
            connection.settimeout(BUSY_LIMIT)
            try:
                connection.connect(str(path))
                connection.sendall(self._line)
            except OSError as error:
                connection.close()
                if isinstance(error, ConnectionRefusedError | FileNotFoundError):
                    return False
                if time.monotonic() >= end:
                    return True
                time.sleep(BUSY_PERIOD)
            else:
                self._asked[connection.fileno()] = path, connection
                return True

    def answers(self, limit: float) -> dict[Path, str]:
        """Return the answers that come within `limit` seconds, as soon as all have come."""
        end, heard = time.monotonic() + limit, dict[Path, bytes]()
        poll, left = select.poll(), set(self._asked)
        for number in left:
            poll.register(number, select.POLLIN)
        while left and (seconds := end - time.monotonic()) > 0:
            for number, _ in poll.poll(seconds * 1000):
                path, connection = self._asked[number]
                said = b""
                with suppress(OSError):
                    said = connection.recv(MOST_BYTES)
                heard[path] = heard.get(path, b"") + said
                if not said:  # that was all
                    poll.unregister(number)
                    left.discard(number)
        return {path: said.decode(errors="replace") for path, said in heard.items()}


def _read(text: bytes) -> Stop:
    """Return the stop that follows a request, with an identity. Whatever else the text is, it is a stop."""
    about: dict[str, object] = {"type": "stop", "direct": secrets.token_hex(8)}
    with suppress(ProtocolError):
        read = cast(dict[str, object], read_as(text, Stop))
        about |= {name: read[name] for name in ("direct", "by", "at") if read.get(name)}
    return cast(Stop, about)


def _send(asking: socket.socket, line: str) -> None:
    with asking, suppress(OSError):
        asking.sendall(line.encode())
