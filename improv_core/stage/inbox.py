"""Where everything that arrives at a stage waits for its loop. Standard library only."""

from __future__ import annotations

import queue
from collections import deque

from improv_core.stage.loop import Arrival
from improv_core.stage.sinks import Edge


class Inbox:
    """A queue that edges overtake: a stop is never behind anything else. Any thread may put, and signal handlers too.

    Edges stay in the order in which they came, and so does everything else.
    """

    def __init__(self) -> None:
        self._edges: deque[Edge] = deque()
        self._others: deque[Arrival] = deque()
        self._signals: queue.SimpleQueue[None] = queue.SimpleQueue()  # one for each arrival

    def put(self, arrival: Arrival) -> None:
        if isinstance(arrival, Edge):
            self._edges.append(arrival)
        else:
            self._others.append(arrival)
        self._signals.put(None)

    def get(self, *, timeout: float | None) -> Arrival:
        """The next arrival. Raises queue.Empty after `timeout` seconds without one (None: never)."""
        self._signals.get(timeout=timeout)
        return self._edges.popleft() if self._edges else self._others.popleft()
