"""Answers that people type in a terminal, line by line, while something else may happen."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import threading
from collections.abc import Callable

from improv_core.commands.exit_codes import CommandError

MAX_BYTES = 4096
"""Bytes that are read at once."""


class TypedAnswers:
    """Answers to questions, from standard input; `say` shows a line."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self.say = say
        self._read = b""

    async def to(self, question: str) -> str:
        """Ask a question and return the line that answers it, without spaces around it. Raises CommandError if nobody
        can answer."""
        self._drop_typed()
        self.say(question)
        while b"\n" not in self._read:
            if not (more := await _next_bytes()):
                raise CommandError("no answer: nothing was changed")
            self._read += more
        line, self._read = self._read.split(b"\n", 1)
        return line.decode(errors="replace").strip()

    def _drop_typed(self) -> None:
        """Drop lines that people typed before the question: an answer may move robots, so it must be meant."""
        if os.name != "nt" and sys.stdin and sys.stdin.isatty():
            import termios

            self._read = b""
            termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)


async def _next_bytes() -> bytes:
    """Read the next bytes on a thread that can be abandoned, so that Ctrl-C ends the command at once."""
    loop = asyncio.get_running_loop()
    found: asyncio.Future[bytes] = loop.create_future()

    def give(more: bytes) -> None:
        if not found.done():
            found.set_result(more)

    def read() -> None:
        try:
            more = os.read(sys.stdin.fileno(), MAX_BYTES) if sys.stdin else b""
        except OSError:  # the terminal is gone
            more = b""
        with contextlib.suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(give, more)

    threading.Thread(target=read, daemon=True).start()
    return await found
