"""The end of stop sockets that asks: it asks many servers at once, and one that hangs delays no other."""

from __future__ import annotations

import json
import select
import socket
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # `improv stop` imports nothing that it does not need: somebody is in a hurry
    from improv_core.protocol.commands import Stop

ASK = b"stop\n"
"""The line with which a request begins. One line of JSON about the stop may follow, in the same packet."""
MAX_BYTES = 1_000
"""The longest request, and the most bytes of an answer to read at once. More of a request is not read."""
BUSY_LIMIT, BUSY_PERIOD = 0.05, 0.001
"""Seconds for which to ask again a server that takes no connections, as in a flood, and seconds between two tries."""


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
                    said = connection.recv(MAX_BYTES)
                heard[path] = heard.get(path, b"") + said
                if not said:  # that was all
                    poll.unregister(number)
                    left.discard(number)
        return {path: said.decode(errors="replace") for path, said in heard.items()}
