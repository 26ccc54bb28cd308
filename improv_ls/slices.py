"""Runs long work on the event loop in slices, so messages are read in between."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Generic, TypeVar

from greenlet import GreenletExit, getcurrent, greenlet

from improv_core.slices import on_checkpoint

SLICE = 0.005
"""Seconds for which work runs before messages are read again."""
BRIEF = 1 / 4
"""The first slice of work that shows something when it is over, as a share of others."""
T = TypeVar("T")


class _Work(Generic[T]):
    """A function that runs in a greenlet, because it can stop in the middle of any call."""

    def __init__(self, function: Callable[[], T], future: Future[T], share: float) -> None:
        self.function = function
        self.future = future
        self.share = share  # of a slice that its next one lasts
        self.until = self.spent = 0.0
        self.worker: greenlet | None = None
        self.result: T | None = None
        self.error: Exception | None = None
        self.is_over = False


class Slices:
    """Runs work on one thread. `soon` calls a function after the messages that have arrived; `clock` is in seconds.

    The work that has had the least time runs next. So a small request never waits for the rest of a large one, and an
    analysis of the latest text comes before older ones.
    """

    def __init__(self, soon: Callable[[Callable[[], object]], object], clock: Callable[[], float] = time.monotonic):
        self._soon = soon
        self._clock = clock
        self._works: list[_Work[Any]] = []
        self._running: _Work[Any] | None = None
        self._idle: greenlet | None = None  # kept for the next job: making one takes as long as a short job
        self._is_used = False  # true once a slice has been used up since messages were last read
        on_checkpoint(self._look)

    def begin(self, function: Callable[[], T], future: Future[T] | None = None, share: float = 1.0) -> Future[T]:
        """Run a function. If that takes no longer than a slice, or this share of one, the returned future is already
        done; canceling or setting the future drops the work."""
        work = _Work(function, future or Future(), share)
        if not self._is_used:
            self._run(work)
        if not work.future.done():
            self._works.append(work)
            if len(self._works) == 1:
                self._soon(self._continue)
        return work.future

    @property
    def is_working(self) -> bool:
        """True if the caller is work in slices."""
        return self._running is not None and getcurrent() is self._running.worker

    def is_over(self) -> bool:
        """Return whether the caller should keep its results and `rest`: soon it will have to stop at a checkpoint."""
        work = self._running
        return work is not None and self._clock() >= work.until - SLICE * work.share / 5

    def rest(self) -> None:
        """Let messages be read, if the caller's slice is nearly over."""
        if self.is_over():
            self._stop()

    def _look(self) -> None:
        work = self._running
        if work and self._clock() >= work.until:
            self._stop()

    def _stop(self) -> None:
        """Stop here until the next slice, unless the caller is another thread, or no work."""
        worker = getcurrent()
        if self._running and worker is self._running.worker and worker.parent:
            worker.parent.switch()

    def _continue(self) -> None:
        """Run one more slice."""
        self._is_used = False
        for work in [work for work in self._works if work.future.done()]:
            if work.worker and not work.is_over:
                work.worker.throw(GreenletExit)
            self._works.remove(work)
        if self._works:
            work = min(self._works, key=lambda work: work.spent)
            self._run(work)
            if work.is_over:
                self._works.remove(work)
        if self._works:
            self._soon(self._continue)
        else:
            self._is_used = False

    def _run(self, work: _Work[Any]) -> None:
        began = self._clock()
        work.until = began + SLICE * work.share
        before, self._running = self._running, work
        worker = work.worker
        if not worker:
            worker, self._idle = self._idle or greenlet(self._serve), None
            work.worker, worker.parent = worker, getcurrent()
        worker.switch()
        self._running = before
        work.spent += self._clock() - began
        if not work.is_over:
            work.share = 1.0
            self._is_used = True
            return
        self._idle = worker
        if work.future.done():  # dropped, or set
            return
        if work.error:
            work.future.set_exception(work.error)
        else:
            work.future.set_result(work.result)

    def _serve(self) -> None:
        """Run one job after another, in a greenlet."""
        while work := self._running:
            try:
                work.result = work.function()
            except Exception as error:
                work.error = error
            work.is_over = True
            parent = getcurrent().parent
            del work
            if parent:
                parent.switch()
