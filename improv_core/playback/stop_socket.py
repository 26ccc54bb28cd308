"""For `improv stop`: each process that plays for this user listens on its own socket, through which others can stop it.

The sockets are files in a folder that only this user can access. Nothing is reachable over a network.
"""

from __future__ import annotations

import os
import socket
import stat
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

ASK = b"stop\n"
LIMIT = 2.0
"""Seconds to wait for a process that does not answer."""


class StopSocketError(Exception):
    """The sockets can't be used. The message is one line that says why."""


class StopSocket:
    """Calls `stop` on a thread of its own whenever `improv stop` asks for it, and answers with the result.

    `stop` returns one line that says what it stopped. Raises StopSocketError.
    """

    def __init__(self, stop: Callable[[], str]) -> None:
        self._stop = stop
        self._path = _folder() / f"{os.getpid()}-{id(self):x}.sock"
        self._server = socket.socket(socket.AF_UNIX)
        try:
            self._server.bind(str(self._path))
            self._path.chmod(0o600)
            self._server.listen()
        except OSError as error:
            self._server.close()
            raise StopSocketError(f"{self._path}: {error.strerror or error}") from None
        threading.Thread(target=self._serve, daemon=True).start()

    def close(self) -> None:
        with suppress(OSError):
            self._path.unlink()
        with suppress(OSError):
            self._server.shutdown(socket.SHUT_RDWR)  # wakes the thread
        self._server.close()

    def _serve(self) -> None:
        while True:
            try:
                asking, _ = self._server.accept()
            except OSError:  # closed
                return
            with asking, suppress(OSError):
                asking.settimeout(LIMIT)
                if asking.recv(len(ASK)) == ASK:
                    asking.sendall(self._stop().encode())


def stop_all() -> Iterator[str]:
    """Stop everything that plays for this user. Yields each answer, or why there is none. Raises StopSocketError."""
    for path in sorted(_folder().glob("*.sock")):
        with socket.socket(socket.AF_UNIX) as asking:
            asking.settimeout(LIMIT)
            try:
                asking.connect(str(path))
                asking.sendall(ASK)
                yield asking.makefile(encoding="utf-8", errors="replace").read()
            except (ConnectionRefusedError, FileNotFoundError):
                path.unlink(missing_ok=True)  # its process was killed
            except OSError:
                yield f"process {path.name.partition('-')[0]} does not answer: end it with `kill`"


def _folder() -> Path:
    """The user's own runtime folder, which nobody else can access."""
    if not hasattr(socket, "AF_UNIX"):
        raise StopSocketError("this system has no Unix sockets")
    given = os.environ.get("XDG_RUNTIME_DIR")
    folder = Path(given, "improv") if given else Path(tempfile.gettempdir(), f"improv-{os.getuid()}")
    try:
        folder.mkdir(0o700, exist_ok=True)
        found = folder.lstat()
    except OSError as error:
        raise StopSocketError(f"{folder}: {error.strerror or error}") from None
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise StopSocketError(f"{folder} must be a folder that only you can access: remove it")
    return folder
