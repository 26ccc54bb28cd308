"""The end of a stop socket that hears stops. Neither a silent connection nor a flood of them delays one."""

from __future__ import annotations

import json
import os
import secrets
import socket
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import cast

from improv_core.protocol.commands import Stop
from improv_core.safety.private_folder import private_folder
from improv_core.safety.stop_request import ASK, MAX_BYTES
from improv_core.score.json_types import fits

with suppress(ImportError):  # on Windows, where nothing listens
    import fcntl

READ_LIMIT = 2.0
"""Seconds for which a connection may stay silent."""
MAX_SILENT = 128
"""The most connections that may be silent at a time. One more closes the oldest, unless its request has arrived."""
LOOK_PERIOD = 1.0
"""Seconds between checks for the socket, which somebody may have removed together with everything in /tmp."""
AGAIN = 0.05
"""Seconds until the next try if the system had no file handle for a new connection."""

Answer = Callable[[str], None]
"""Sends the answer, and closes the connection. Callable on any thread."""
Take = Callable[[Stop, Answer], None]
"""Obeys a stop, which has an identity (`direct`). Called on threads."""


class StopServer:
    """Listens at a path that only this user can use, until it is closed. Raises OSError, also for a path that is too
    long, and RuntimeError if there can't be more threads.

    It locks the path's folder, so that systemd leaves the socket there: it removes files from /tmp after ten days, on
    many systems, and doesn't know that a socket which was moved is in use (tmpfiles.d(5)). If somebody else removes it,
    it comes back.
    """

    def __init__(self, path: Path, take: Take) -> None:
        self._path = path
        self._take = take
        self._closed = threading.Event()
        self._changing = threading.Lock()
        self._silent: deque[socket.socket] = deque(maxlen=MAX_SILENT)
        self._server, self._folder = _listening_at(path)
        try:
            threading.Thread(target=self._serve, daemon=True).start()
        except RuntimeError:
            self.close()
            raise

    def close(self) -> None:
        with self._changing:
            if self._closed.is_set():
                return
            self._closed.set()
            with suppress(OSError):
                self._path.unlink()
            self._end_server()

    def _end_server(self) -> None:
        with suppress(OSError):
            self._server.shutdown(socket.SHUT_RDWR)  # wakes the thread
        self._server.close()
        os.close(self._folder)

    def _come_back(self) -> None:
        """Listen again if the socket has been removed, unless it is closed."""
        with self._changing, suppress(OSError):
            if not self._closed.is_set() and not self._path.exists() and private_folder(self._path.parent, os.getuid()):
                server, folder = _listening_at(self._path)
                self._end_server()
                self._server, self._folder = server, folder

    def _serve(self) -> None:
        while not self._closed.is_set():
            try:
                asking, _ = self._server.accept()
            except TimeoutError:
                self._come_back()
                continue
            except OSError:  # closed; or the system has no file handles left for now
                self._closed.wait(AGAIN)
                continue
            if len(self._silent) == MAX_SILENT:
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
            said = asking.recv(MAX_BYTES)
        with suppress(ValueError, IndexError):  # later ones have replaced it
            self._silent.remove(asking)
        if said.startswith(ASK):
            self._take(_read(said[len(ASK) :]), partial(_send, asking))
        else:
            asking.close()


def _listening_at(path: Path) -> tuple[socket.socket, int]:
    """Return a socket that listens at a path, and a handle that locks its folder. Raises OSError."""
    server, folder, draft = socket.socket(socket.AF_UNIX), os.open(path.parent, os.O_RDONLY), path.with_suffix(".new")
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(folder, fcntl.LOCK_SH)
        server.settimeout(LOOK_PERIOD)
        server.bind(str(draft))
        draft.chmod(0o600)
        server.listen()
        draft.rename(path)  # whoever asks removes a socket that nobody listens on, as this one was until now
    except OSError:
        server.close()
        os.close(folder)
        with suppress(OSError):
            draft.unlink(missing_ok=True)
        raise
    return server, folder


def _read(text: bytes) -> Stop:
    """Return the stop that follows a request, with an identity. Whatever else the text is, it is a stop."""
    about: dict[str, object] = {"type": "stop", "direct": secrets.token_hex(8)}
    with suppress(ValueError, RecursionError):
        if fits(read := json.loads(text), Stop):
            about |= {name: read[name] for name in ("direct", "by", "at") if read.get(name)}
    return cast(Stop, about)


def _send(asking: socket.socket, line: str) -> None:
    with asking, suppress(OSError):
        asking.sendall(line.encode())
