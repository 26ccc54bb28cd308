"""The things that may arrive while a stage plays, and a queue of messages to a stage, in which urgent ones overtake the
requests of people at an editor or a page."""

from __future__ import annotations

import queue
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from improv_core.protocol.commands import COMMANDS, PageRequest, Pause, Stop
from improv_core.protocol.messages import Ping, Play, ToStage, after
from improv_core.protocol.output import Alarm, Edge, RawJoints, RawPoses
from improv_core.score.peer_clock import Anchor
from improv_core.score.senses import RobotSense

URGENT = {row.name: row.voids for row in COMMANDS.values() if row.overtakes} | {"ping": frozenset[str]()}
"""Each urgent message, and the requests that it makes void: those made before it must not be obeyed after it."""
OVERTAKEN = COMMANDS.keys() - URGENT.keys() | {
    "sensed", "decided", "seen", "measured", "joints", "program", "source", "draft", "answer"
}  # fmt: skip
"""The messages that urgent ones overtake: never a score, so one sent before a stop can't undo it."""

MAX_SENSED = 1_000
"""The most edges of senses that may wait. If more come, only the latest of each sense to each value count."""

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is not a valid message, or whose score can't be read: the reason, and whether it was a score."""

    problem: str
    is_score: bool = False


@dataclass(frozen=True, slots=True)
class Lost:
    """A score of this generation that builds on one that was never read. `after` is as in the protocol."""

    generation: int
    after: int | None = None


@dataclass(frozen=True, slots=True)
class First:
    """A message from the channel of stops, and its number."""

    message: Stop | Pause | Ping
    number: int


@dataclass(frozen=True, slots=True)
class DirectStop:
    """A stop that has come straight to the stage, with its identity. `confirm` is called once the output has all
    zeros."""

    stop: Stop
    confirm: Callable[[], None]


@dataclass(frozen=True, slots=True)
class End:
    """Standard input has ended or, because of a problem, can't be read; or a signal asks the stage to end."""

    problem: str = ""


Ordered = ToStage | Play | Unreadable | Lost
"""Arrivals from standard input, which the loop handles in their order."""
Arrival = Ordered | First | DirectStop | Edge | RawPoses | RawJoints | Alarm | Anchor | End


@dataclass(frozen=True, slots=True)
class OutputChannel:
    """The functions that an output may call, on any thread.

    `hear` gets edges, poses, alarms, and anchors, and the end if the output can receive nothing more. `ask` gets the
    requests of people who use the output's own tools. `warn` gets lines for people.
    """

    hear: Callable[[Arrival], None]
    ask: Callable[[PageRequest], None]
    warn: Callable[[str], None]


Request = tuple[str, int | None]
"""The type of a message that a stop may make void, and the number of messages that were sent on the channel of stops
before it (None if nobody counts them). The type is empty for arrivals that no stop affects."""


def request_in(arrival: Ordered) -> Request:
    """Return what a stop may make void in an arrival."""
    if isinstance(arrival, Play):
        return "load" if arrival.score.moves else "", after(arrival.load)
    if isinstance(arrival, Lost):
        return "load", arrival.after
    return ("", None) if isinstance(arrival, Unreadable) else (arrival["type"], after(arrival))


class UrgentQueue(Generic[Item]):
    """Any thread and any signal handler may put items in; one thread gets them.

    Edges overtake everything else, except that those of robots' senses, which may be many, let a stop go first and
    otherwise take turns with the rest: a sensor that floods must not hold up pings or scores.
    """

    def __init__(self) -> None:
        # Safe in a signal handler. An item with True overtakes all others.
        self._arriving: queue.SimpleQueue[tuple[Item, bool]] = queue.SimpleQueue()
        self._first: deque[Item] = deque()
        self._edges: deque[Item] = deque()
        self._sensed: deque[Any] = deque()
        self._took_sensed = False  # last
        self._waiting: deque[Item] = deque()  # belongs to the thread that gets

    def put(self, item: Item) -> None:
        """Add an item, after all others unless it is urgent."""
        self._arriving.put((item, False))

    def put_first(self, item: Item) -> None:
        """Add an item that overtakes all others, except those that were put first before it."""
        self._arriving.put((item, True))

    def get(self, *, timeout: float | None = None) -> Item:
        """Return the next item. Raises queue.Empty after `timeout` seconds without one (None: never)."""
        while not self._arriving.empty():
            item, first = self._arriving.get_nowait()
            if first:
                self._first.append(item)
            elif not isinstance(item, Edge):
                self._arrange(item)
            elif isinstance(item.what, RobotSense):
                self._sensed.append(item)
            else:
                self._edges.append(item)
        if self._first:
            return self._first.popleft()
        if self._edges:
            return self._edges.popleft()
        if self._sensed and not (self._waiting and (self._took_sensed or _kind(self._waiting[0]) == "stop")):
            if len(self._sensed) > MAX_SENSED:
                latest = {(edge.what, edge.value): edge for edge in self._sensed}
                self._sensed = deque(sorted(latest.values(), key=lambda edge: edge.at))
            self._took_sensed = True
            taken: Item = self._sensed.popleft()
            return taken
        self._took_sensed = False
        if self._waiting:
            return self._waiting.popleft()
        item, _ = self._arriving.get(timeout=timeout)
        return item

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
    """Return the type of a message; empty for other items."""
    return str(item["type"]) if isinstance(item, Mapping) else ""
