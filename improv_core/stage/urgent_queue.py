"""A queue of messages to a stage in which urgent ones overtake what people at an editor or a page asked for."""

from __future__ import annotations

import queue
from collections import deque
from collections.abc import Mapping
from typing import Generic, TypeVar

from improv_core.score.senses import RobotSense
from improv_core.stage.sinks import Edge

OVERTAKEN = frozenset(
    {
        *("pause", "resume", "seek", "speed", "silence", "held", "cue", "key", "force"),
        *("sensed", "decided", "measured", "program", "source", "answer"),
    }
)
"""What urgent messages overtake. They never overtake a score, so a stop can't be undone by a score sent before it."""
URGENT = {
    "hush": frozenset({"pause", "resume", "seek", "restart", "cue"}),
    "released": frozenset({"held"}),
    "ping": frozenset[str](),
}
"""Each urgent message, and what it makes void: requests that were made before it and must not be obeyed after it."""

Item = TypeVar("Item")


class UrgentQueue(Generic[Item]):
    """Any thread and any signal handler may put items in; one thread gets them.

    Edges overtake everything else, except that those of robots' senses, which may be many, let a stop go first.
    """

    def __init__(self) -> None:
        self._arriving: queue.SimpleQueue[Item] = queue.SimpleQueue()  # safe in a signal handler
        self._edges: deque[Item] = deque()
        self._sensed: deque[Item] = deque()
        self._waiting: deque[Item] = deque()  # belongs to the thread that gets

    def put(self, item: Item) -> None:
        """Add an item, behind all others unless it is urgent."""
        self._arriving.put(item)

    def get(self, *, timeout: float | None = None) -> Item:
        """The next item. Raises queue.Empty after `timeout` seconds without one (None: never)."""
        while not self._arriving.empty():
            item = self._arriving.get_nowait()
            if isinstance(item, Edge):
                (self._sensed if isinstance(item.what, RobotSense) else self._edges).append(item)
            else:
                self._arrange(item)
        if self._edges:
            return self._edges.popleft()
        if self._sensed and not (self._waiting and _kind(self._waiting[0]) == "hush"):
            return self._sensed.popleft()
        return self._waiting.popleft() if self._waiting else self._arriving.get(timeout=timeout)

    def _arrange(self, item: Item) -> None:
        overtaken: deque[Item] = deque()
        void = URGENT.get(_kind(item))
        while void is not None and self._waiting and _kind(self._waiting[-1]) in OVERTAKEN:
            other = self._waiting.pop()
            if _kind(other) not in void:
                overtaken.appendleft(other)
        self._waiting.append(item)
        self._waiting.extend(overtaken)


def _kind(item: object) -> str:
    """The type of a message; nothing for anything else that waits with messages."""
    return str(item["type"]) if isinstance(item, Mapping) else ""
