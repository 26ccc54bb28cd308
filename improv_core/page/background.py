"""Work for the page that takes long enough to delay robots, done in the background."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

Work = Callable[[], None]
Do = Callable[[Work], None]
"""Does such work, one task after another. A system without threads does it at once."""


class OwnThread:
    """Does it on its own thread, for which the process doesn't wait when it ends. `do` may be called from any
    thread."""

    def __init__(self, name: str) -> None:
        self._work: queue.SimpleQueue[Work | None] = queue.SimpleQueue()
        threading.Thread(target=self._run, name=name, daemon=True).start()

    def do(self, work: Work) -> None:
        self._work.put(work)

    def close(self) -> None:
        """End the thread, once it has done what waits."""
        self._work.put(None)

    def _run(self) -> None:
        while (work := self._work.get()) is not None:
            work()
