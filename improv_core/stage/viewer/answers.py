"""Answers that take time to compute: what comes next in the score, and the picture of its paths."""

from __future__ import annotations

import asyncio
import json
import queue
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TypeVar

from improv_core.score.score import Score
from improv_core.score.svg import plot
from improv_core.stage.messages import Sensed
from improv_core.stage.viewer.lookahead import MOST_MOMENTS, window
from improv_core.stage.viewer.messages import AskWindow, Window

MOST_BEATS = 256
"""Beats in one window."""
WINDOWS_KEPT = 64
"""Windows that are kept for other pages."""

Answer = TypeVar("Answer")


@dataclass(frozen=True, eq=False)
class Shown:
    """The score on the pages, its generation, and what was sensed in it: one value, because it is set on one thread and
    read on another."""

    score: Score
    generation: int
    sensed: tuple[Sensed, ...] = ()


class Answers:
    """Computes answers on a thread of its own, so that a page that asks for a lot delays no robot and no other page.

    Set `shown` from any thread.
    """

    def __init__(self) -> None:
        self.shown: Shown | None = None
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        # Nobody waits for this thread at the end.
        threading.Thread(target=self._run, name="improv-answers", daemon=True).start()

    def close(self) -> None:
        """Compute nothing that has not been started."""
        self._work.put(None)

    async def compute(self, answer: Callable[[], Answer]) -> Answer | None:
        """The answer, from the thread; None if it fails, which is reported."""
        loop = asyncio.get_running_loop()
        computed: asyncio.Future[Answer | None] = loop.create_future()
        self._work.put(partial(_answer, loop, computed, answer))
        return await computed

    def window(self, question: AskWindow) -> str | None:
        """The message that answers a `window` request; None if it asks about another score."""
        shown = self.shown
        if shown is None or question["generation"] != shown.generation:
            return None
        return _window(shown, question["from"], min(question["to"], question["from"] + MOST_BEATS))

    def picture(self) -> str | None:
        """The score's paths as SVG; None if there is no score."""
        return _picture(self.shown) if self.shown else None

    def _run(self) -> None:
        while (work := self._work.get()) is not None:
            work()


def _answer(
    loop: asyncio.AbstractEventLoop, computed: asyncio.Future[Answer | None], answer: Callable[[], Answer]
) -> None:
    text = None
    try:
        text = answer()
    except Exception as problem:  # one answer is missing; the next ones are not
        print(f"the page: {problem!r}", file=sys.stderr)
    with suppress(RuntimeError):  # the loop is closed
        loop.call_soon_threadsafe(_settle, computed, text)


def _settle(computed: asyncio.Future[Answer | None], text: Answer | None) -> None:
    if not computed.done():  # whoever asked may be gone
        computed.set_result(text)


@lru_cache(WINDOWS_KEPT)
def _window(shown: Shown, start: float, end: float) -> str:
    robots = window(shown.score, start, end, shown.sensed)
    message: Window = {"type": "window", "generation": shown.generation, "from": start, "to": end, "robots": robots}
    return json.dumps(message)


@lru_cache(1)
def _picture(shown: Shown) -> str:
    return plot(shown.score, most_moments=MOST_MOMENTS // max(len(shown.score.parts), 1))
