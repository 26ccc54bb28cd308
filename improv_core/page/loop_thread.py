"""An event loop on a thread of its own, for a server that has to answer whatever the main thread does."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any


class LoopThread:
    """Runs a server on its own thread, until it is closed."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._name = name
        self._stop = asyncio.Event()
        self._thread: threading.Thread | None = None

    def start(self, serve: Callable[[asyncio.Event], Coroutine[Any, Any, None]]) -> None:
        """Begin to `serve`, until the event that it gets is set."""
        self._thread = threading.Thread(target=self._run, args=(serve,), name=self._name, daemon=True)
        self._thread.start()

    def soon(self, what: Callable[..., None], *values: object) -> None:
        """Have the thread call a function."""
        with suppress(RuntimeError):  # already closed
            self._loop.call_soon_threadsafe(what, *values)

    def close(self) -> None:
        """Have the server end, after all that it was to call before, and wait for that."""
        self.soon(self._stop.set)
        if self._thread:
            self._thread.join()

    def _run(self, serve: Callable[[asyncio.Event], Coroutine[Any, Any, None]]) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(serve(self._stop))
        finally:
            self._loop.close()
