"""The stop sockets of stages: each stage listens on its own, and whoever stops robots asks all stages in parallel.

So a stop needs nobody's help, not even the session's. The sockets of a performance are files whose names begin with one
path, its `show`. A stage that dies leaves its socket there: it counts as one that has not answered, until another stage
has taken over its robots and listens in its place.
"""

from __future__ import annotations

import json
import re
import secrets
import select
import socket
import time
import zlib
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import cast

from improv_core.protocol.commands import Stop
from improv_core.protocol.decoding import ProtocolError, read_as
from improv_core.safety.stop_server import ASK, Answer, StopServer

SUFFIX = ".stage"
"""The end of the names of these sockets."""
SIMULATOR, HERE = "simulator", "ros"
"""The names of two stages: the simulator's, and that of the real robots without a host. Others have their host's."""
LONGEST_NAME = 40
"""The most characters of a stage's name in that of its socket, whose path may have 107 bytes."""
BUSY_LIMIT, BUSY_PERIOD = 0.05, 0.001
"""Seconds for which to ask a stage again that takes no more connections, as in a flood, and seconds between two
tries."""
OBEYED = "obeyed\n"
"""The answer of a stage, once its output has all zeros."""

Take = Callable[[Stop, Answer], None]
"""Has a stage obey a stop that has an identity (`direct`), and answer `OBEYED` then. Called on threads."""


def stop_stages(show: Path, stop: Stop, limit: float) -> Sequence[str] | None:
    """Have all stages of a performance stop, in parallel. Returns the names, for people, of those that have not obeyed
    within `limit` seconds although they move real robots, or of the simulator if there are no others. None if no stage
    can be asked like this."""
    found = sockets_of(show)
    with AskedStages(stop) as asked:
        for path in found:
            asked.ask(path)
        obeyed = asked.obeyed(limit)
    return stages_not_stopped(map(stage_of, found), [stage_of(path) for path in obeyed]) if found else None


def stages_not_stopped(stages: Iterable[str], obeyed: Collection[str]) -> list[str]:
    """Return the names, for people, of those stages that have to obey before robots count as stopped, and have not."""
    asked = {*stages}
    real = asked - {SIMULATOR}
    here = "the stage here" if len(real) > 1 else "the real robots"
    names = {SIMULATOR: "the simulator", HERE: here}
    return [names.get(stage, stage) for stage in sorted((real or asked) - {*obeyed})]


def socket_of(show: Path, stage: str) -> Path:
    """Return the path of a stage's socket."""
    name = re.sub(r"[^\w@.:-]", "_", stage, flags=re.ASCII)[:LONGEST_NAME]
    return show.with_name(f"{show.name}.{name if name == stage else f'{name}~{zlib.crc32(stage.encode()):x}'}{SUFFIX}")


def stage_of(path: Path) -> str:
    """Return the name of the stage with this socket; of a long name, the beginning."""
    return path.name.removesuffix(SUFFIX).partition(".")[2].partition("~")[0]


def sockets_of(show: Path) -> list[Path]:
    """Return the sockets of a performance, also those of stages that have died."""
    with suppress(OSError):
        return sorted(show.parent.glob(f"{show.name}.*{SUFFIX}"))
    return []


def forget(show: Path, stage: str | None = None) -> None:
    """Remove the socket of a stage that has died and left no robot moving, or those of all stages."""
    for path in sockets_of(show) if stage is None else [socket_of(show, stage)]:
        with suppress(OSError):
            path.unlink(missing_ok=True)


class StageSocket:
    """The stop socket of a stage, on which `take` gets each stop.

    If a stage has died there, its robots may still move, and this one can't stop robots that it doesn't know. So it
    listens only after `take_over`. Raises OSError.
    """

    def __init__(self, show: Path, stage: str, take: Take) -> None:
        self._path = socket_of(show, stage)
        self._take = take
        self._server: StopServer | None = None
        if not self._path.exists():
            self._listen()

    def take_over(self) -> None:
        """Listen in place of a stage that has died: its robots obey this one now."""
        if self._server is None:
            with suppress(OSError, RuntimeError):  # it counts as one that has not answered
                self._listen()

    def close(self) -> None:
        """Stop listening: the robots stand, and nobody moves them any more."""
        if self._server:
            self._server.close()

    def _listen(self) -> None:
        self._server = StopServer(self._path, lambda text, answer: self._take(read_stop(text), answer))


def read_stop(text: bytes) -> Stop:
    """Return the stop that follows a request, with an identity. Whatever else the text is, it is a stop."""
    stop: Stop = {"type": "stop", "direct": secrets.token_hex(8)}
    with suppress(ProtocolError):
        read = cast(Stop, read_as(text, Stop))
        if "by" in read:
            stop["by"] = read["by"]
        if "at" in read:
            stop["at"] = read["at"]
        stop["direct"] = read.get("direct") or stop["direct"]
    return stop


class AskedStages:
    """Stages that are asked to obey a stop."""

    def __init__(self, stop: Stop) -> None:
        self._line = ASK + json.dumps(stop).encode() + b"\n"
        self._waiting: dict[socket.socket, Path] = {}

    def __enter__(self) -> AskedStages:
        return self

    def __exit__(self, *_: object) -> None:
        for connection in self._waiting:
            connection.close()

    def ask(self, path: Path) -> bool:
        """Ask a stage. Returns False if none listens."""
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
                self._waiting[connection] = path
                return True

    def obeyed(self, limit: float) -> list[Path]:
        """Return the sockets of those that obey within `limit` seconds, as soon as all have answered."""
        end = time.monotonic() + limit
        obeyed = []
        poll = select.poll()
        by_number = {connection.fileno(): connection for connection in self._waiting}
        for number in by_number:
            poll.register(number, select.POLLIN)
        while by_number and (left := end - time.monotonic()) > 0:
            for number, _ in poll.poll(left * 1000):
                poll.unregister(number)
                connection = by_number.pop(number)
                with suppress(OSError):
                    if connection.recv(len(OBEYED)) == OBEYED.encode():
                        obeyed.append(self._waiting[connection])
        return obeyed
