"""Queues arrivals from standard input and releases each at its time. The sink gets the robots of a new score a few at a
time, so that stops and the score that plays don't wait for a thousand of them."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator

from improv_core.ipc.arrivals import Ordered, Request, request_in
from improv_core.protocol.commands import VOIDED_BY_STOP, Pause
from improv_core.protocol.limits import MAX_AHEAD
from improv_core.protocol.messages import Play
from improv_core.safety.stops import StopFence
from improv_core.score.score import Score

SLICE = 0.005
"""Seconds for which the sink gets to know robots at a time."""


class CommandQueue:
    """`preload` makes the robots of a score known, a few at each step; `clock` returns the time in seconds."""

    def __init__(self, preload: Callable[[Score], Iterator[None]], clock: Callable[[], float]) -> None:
        self._preload = preload
        self._clock = clock
        self._waiting: deque[Ordered] = deque()
        self._preloading: tuple[Play, Request, Iterator[None]] | None = None
        self.fence = StopFence()
        """The stops that have overtaken arrivals: those arrivals are dropped."""
        self._pause: Pause | None = None  # it came on the channel of stops, and takes effect at its time

    @property
    def is_busy(self) -> bool:
        """True while robots of a score are not known yet. If so, call `next` again soon."""
        return self._preloading is not None

    @property
    def due(self) -> float:
        """The time for which the next arrival waits; infinite if there is none, or if it waits for something else."""
        now = self._clock()
        first = self._first
        at = _time_of(first, now) if first else -math.inf
        return at if at > now else math.inf

    @property
    def comes_now(self) -> bool:
        """True if the next arrival has waited for its time, and that has come."""
        is_next = self._pause is not None or self._preloading is None
        first = self._first
        return is_next and isinstance(first, dict) and "at" in first and self.due == math.inf

    @property
    def _first(self) -> Ordered | None:
        return self._pause or (self._waiting[0] if self._waiting else None)

    def add(self, arrival: Ordered) -> None:
        self._waiting.append(arrival)

    def pause(self, pause: Pause) -> bool:
        """Keep a pause until its time, before all that came behind it. Returns False if its time has come."""
        now = self._clock()
        if _time_of(pause, now) <= now:
            return False
        self._pause = pause
        return True

    def forget_pause(self) -> None:
        """Forget the pause, because a stop has come instead."""
        self._pause = None

    def stop(self) -> None:
        """Drop arrivals that must not be obeyed after a stop that has itself arrived on standard input."""
        self._waiting = deque(each for each in self._waiting if request_in(each)[0] not in VOIDED_BY_STOP)
        if self._preloading and self._preloading[0].score.moves:
            self._preloading = None

    def next(self) -> Ordered | None:
        """Return the next arrival to handle; None if there is none or a slice of time has passed."""
        end = self._clock() + SLICE
        if self._pause:
            if self.due < math.inf:
                return None
            pause, self._pause = self._pause, None
            return pause
        while self._preloading or self._waiting:
            if not self._preloading:
                request = request_in(self._waiting[0])
                if self.fence.awaits(*request):
                    return None
                if self.fence.voids(*request):
                    self._waiting.popleft()
                    continue
                if self.due < math.inf:
                    return None
                arrival = self._waiting.popleft()
                if not isinstance(arrival, Play):
                    return arrival
                self._preloading = arrival, request, self._preload(arrival.score)
            play, request, steps = self._preloading
            if not self.fence.voids(*request):
                for _ in steps:
                    if self._clock() >= end:
                        return None
                self._preloading = None
                return play
            self._preloading = None
        return None


def _time_of(arrival: Ordered, now: float) -> float:
    """Return the time at which it takes effect, if that is still to come. A score is prepared before its takeover."""
    if not isinstance(arrival, dict):
        return -math.inf
    at = arrival.get("at")
    return at if isinstance(at, float) and at <= now + MAX_AHEAD else -math.inf
