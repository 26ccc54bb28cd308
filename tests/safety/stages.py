"""Stages that only have stop sockets."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from pathlib import Path

from improv_core.protocol.commands import Stop
from improv_core.safety.stage_stops import OBEYED, StageSocket, socket_of
from improv_core.safety.stop_server import Answer

LIMIT = 60.0


class Stages:
    """The stages of a performance; the one that `hangs` doesn't obey."""

    def __init__(self, show: Path, *names: str, hangs: str = "") -> None:
        self.stops: list[tuple[str, Stop]] = []
        self._stopped = threading.Condition()
        self.hangs = hangs
        self.sockets = {name: StageSocket(show, name, self._take(name)) for name in names}

    def wait(self, count: int) -> None:
        """Wait until the stages have got this many stops."""
        with self._stopped:
            assert self._stopped.wait_for(lambda: len(self.stops) >= count, LIMIT)

    def close(self) -> None:
        for each in self.sockets.values():
            each.close()

    def _take(self, name: str) -> Callable[[Stop, Answer], None]:
        def take(stop: Stop, answer: Answer) -> None:
            with self._stopped:
                self.stops.append((name, stop))
                self._stopped.notify_all()
            if name != self.hangs:
                answer(OBEYED)

        return take


def die(show: Path, name: str) -> None:
    """Leave the socket of a stage that was killed."""
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(socket_of(show, name)))
