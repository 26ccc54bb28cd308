"""Stops and pauses: obeyed and counted as they arrive, ahead of everything that still waits. Standard library only."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from typing import Protocol

from improv_core.stage.protocol import Hush, Load, PageRequest, Pause, Resume, ToStage, Watched


class Receiver(Protocol):
    """A stage, as far as stopping it needs."""

    def send(self, message: ToStage) -> None: ...


class Stops:
    """Counts how often everything was to stop or pause, and has all stages do so at once. Every method is thread-safe.

    A request to play carries the count from the moment it arrived. `send` drops it if a stop has come since then, so
    nothing that was requested before a stop plays after it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._stages: list[Receiver] = []
        self.count = 0
        self.latest = 0
        """Unix time of the latest stop, in nanoseconds."""

    def add(self, stage: Receiver) -> None:
        """From now on, this stage is stopped too."""
        with self._lock:
            self._stages.append(stage)

    def discard(self, stage: Receiver) -> None:
        with self._lock:
            if stage in self._stages:
                self._stages.remove(stage)

    def stop(self, message: Hush | Pause | None = None) -> None:
        """Have all stages stop at once, or pause."""
        timed = message.copy() if message else Hush(type="hush")
        timed["at"] = time.monotonic()
        with self._lock:
            self.count += 1
            self.latest = time.time_ns()
            for stage in self._stages:
                stage.send(timed)

    def arrive(self, request: PageRequest | Watched) -> int:
        """Note a request from a page, and obey it if it is a stop or a pause. Returns the count that it carries."""
        if request["type"] == "hush" or request["type"] == "pause":
            self.stop(request)
        return self.count

    def send(self, message: Load | Resume, stages: Iterable[Receiver], asked: int) -> bool:
        """Send what makes robots move, unless a stop has come since the count was `asked`. Returns whether it was
        sent."""
        with self._lock:
            if self.count != asked:
                return False
            for stage in stages:
                stage.send(message)
            return True
