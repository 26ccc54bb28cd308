"""Work for the page that takes time, so that it delays no robot."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Protocol

Work = Callable[[], None]


class Background(Protocol):
    """Where such work is done, one thing after another."""

    def do(self, work: Work) -> None: ...

    def close(self) -> None:
        """Do nothing that has not been started."""


class OwnThread:
    """Does it on a thread of its own, for which nobody waits at the end. `do` may be called from any thread."""

    def __init__(self, name: str) -> None:
        self._work: queue.SimpleQueue[Work | None] = queue.SimpleQueue()
        threading.Thread(target=self._run, name=name, daemon=True).start()

    def do(self, work: Work) -> None:
        self._work.put(work)

    def close(self) -> None:
        self._work.put(None)

    def _run(self) -> None:
        while (work := self._work.get()) is not None:
            work()
