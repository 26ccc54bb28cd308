"""How `improv stop` reaches everything that plays: each process listens on a Unix socket of its own.

The sockets are files in a folder that only this user can enter. Nothing is reachable over a network.
"""

from __future__ import annotations

import os
import secrets
import socket
import stat
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

SUPPORTED = hasattr(socket, "AF_UNIX")
"""Whether this system has Unix sockets."""
ASK = b"stop\n"
IDLE = "nothing was playing"
"""The answer of a process that had nothing to stop."""
LIMIT = 2.0
"""Seconds to wait for a process that does not answer."""


class StopSocketError(Exception):
    """The sockets can't be used. The message is one line that says why."""


class StopSocket:
    """Calls `stop` from a thread whenever `improv stop` asks for it, and answers with the line that `stop` returns.

    Raises StopSocketError.
    """

    def __init__(self, stop: Callable[[], str]) -> None:
        self._stop = stop
        self._path = runtime_folder() / f"{os.getpid()}-{secrets.token_hex(4)}.sock"
        draft = self._path.with_suffix(".new")
        self._server = socket.socket(socket.AF_UNIX)
        try:
            self._server.bind(str(draft))
            draft.chmod(0o600)
            self._server.listen()
            draft.rename(self._path)  # `improv stop` removes a socket that nobody listens on, as this one was until now
        except OSError as error:
            self._server.close()
            draft.unlink(missing_ok=True)
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
            # On a thread of its own: a process that connects and stays silent must not hold up the next one.
            threading.Thread(target=self._answer, args=(asking,), daemon=True).start()

    def _answer(self, asking: socket.socket) -> None:
        with asking, suppress(OSError):
            asking.settimeout(LIMIT)
            if asking.recv(len(ASK)) == ASK:
                asking.sendall(self._stop().encode())


def stop_all() -> Iterator[str]:
    """Stop everything of this user that plays. Yields each answer, or why there was none. Raises StopSocketError."""
    asked: list[tuple[Path, socket.socket]] = []
    with ExitStack() as stack:
        for path in sorted(runtime_folder().glob("*.sock")):
            connection = stack.enter_context(socket.socket(socket.AF_UNIX))
            connection.settimeout(LIMIT)
            try:
                connection.connect(str(path))
                connection.sendall(ASK)
            except (ConnectionRefusedError, FileNotFoundError):
                path.unlink(missing_ok=True)  # its process was killed
            except OSError:
                yield _silent(path)
            else:
                asked.append((path, connection))
        # All are asked before the first answer is awaited: one that hangs must not hold up the others.
        for path, connection in asked:
            try:
                yield connection.makefile(encoding="utf-8", errors="replace").read() or _silent(path)
            except OSError:
                yield _silent(path)


def runtime_folder() -> Path:
    """The folder of the sockets, which nobody else can enter. Raises StopSocketError.

    The same in every terminal and editor of a user, even if XDG_RUNTIME_DIR is not set.
    """
    if not SUPPORTED:
        raise StopSocketError("this system has no Unix sockets")
    given = os.environ.get("XDG_RUNTIME_DIR") or f"/run/user/{os.getuid()}"
    folder = Path(given, "improv")
    if "XDG_RUNTIME_DIR" not in os.environ and not folder.parent.is_dir():
        folder = Path(tempfile.gettempdir(), f"improv-{os.getuid()}")
    try:
        folder.mkdir(0o700, exist_ok=True)
        found = folder.lstat()
    except OSError as error:
        raise StopSocketError(f"{folder}: {error.strerror or error}") from None
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o077:
        raise StopSocketError(f"{folder} must be a folder that only you can access: remove it")
    return folder


def _silent(path: Path) -> str:
    return f"process {path.name.partition('-')[0]} does not answer: end it with `kill`"
