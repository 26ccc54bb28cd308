"""Answers that take time to compute: the next part of the score, and the picture of its paths."""

from __future__ import annotations

import asyncio
import json
import sys
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from functools import partial
from typing import TypeVar

from improv_core.page.background import Do
from improv_core.preview.replaying import followed, note
from improv_core.preview.window import MAX_MOMENTS, window
from improv_core.protocol.messages import Sensed, TransportMessage
from improv_core.protocol.page_messages import AskWindow, Window
from improv_core.score.replay import Replay
from improv_core.score.score import Score
from improv_core.score.svg import plot

MAX_BEATS = 256
"""Beats in one window."""
MAX_EARLY = 1_000
"""Changes of senses that are kept. The simulator runs behind the real robots beside it, so these changes come before
the scene or the jump to which they belong."""
EARLY = 0.01
"""Seconds by which the times of a jump may differ in two stages."""

Answer = TypeVar("Answer")


class Answers:
    """Computes answers in the background, so that a page with many requests delays no robot and no other page.

    `show` and `take` may be called from any thread: answers to later questions take them into account.
    """

    def __init__(self, do: Do) -> None:
        self._score: Score | None = None
        self._picture: str | None = None  # of this score
        self._shown: dict[int, Score] = {}  # by generation: the one that plays, and those that are to take over
        self._replays: dict[int, Replay] = {}  # of these generations
        self._transport: TransportMessage | None = None
        self._sensed: deque[Sensed] = deque(maxlen=MAX_EARLY)
        self._do = do

    def show(self, score: Score, generation: int) -> None:
        """Take the score that pages show; it plays once a transport message has its generation."""
        self._do(partial(self._show, score, generation))

    def take(self, message: TransportMessage | Sensed) -> None:
        """Follow the messages of the stage."""
        self._do(partial(self._take, message))

    async def compute(self, answer: Callable[[], Answer]) -> Answer | None:
        """Compute an answer and return it; report a failure and return None."""
        computed: Future[Answer | None] = Future()
        self._do(partial(_compute, answer, computed))
        return await asyncio.wrap_future(computed)

    def window(self, question: AskWindow) -> str | None:
        """The message that answers a `window` request; None if it asks about another score. For `compute`."""
        generation, start = int(question["generation"]), question["from"]
        end = min(question["to"], start + MAX_BEATS)
        replay = self._replays.get(generation)
        if not replay:
            return None
        robots = window(replay, start, end)
        message: Window = {"type": "window", "generation": generation, "from": start, "to": end, "robots": robots}
        return json.dumps(message)

    def picture(self) -> str | None:
        """The score's paths as SVG; None if there is no score. For `compute`."""
        if self._score and not self._picture:
            self._picture = plot(self._score, most_moments=MAX_MOMENTS // max(len(self._score.parts), 1))
        return self._picture

    def _show(self, score: Score, generation: int) -> None:
        self._score, self._picture = score, None
        self._shown[generation] = score
        if not self._transport or self._transport["generation"] != generation:
            self._replays[generation] = Replay(score)

    def _take(self, message: TransportMessage | Sensed) -> None:
        generation = message["generation"]
        if message["type"] == "sensed":
            self._sensed.append(message)
            if self._transport and self._transport["generation"] == generation:
                note(self._replays[generation], message)
            return
        if score := self._shown.get(generation):
            playing = self._transport["generation"] if self._transport else generation
            replay = followed(self._replays.get(playing), score, self._transport, message)
            if replay is not self._replays[generation]:
                for edge in self._sensed:
                    if edge["generation"] == generation and edge["performed"] >= message["performed"] - EARLY:
                        note(replay, edge)
            self._replays[generation], self._transport = replay, message
            for each in [number for number in self._shown if number < generation]:
                del self._shown[each], self._replays[each]


def _compute(answer: Callable[[], Answer], computed: Future[Answer | None]) -> None:
    text = None
    try:
        text = answer()
    except Exception as problem:  # this answer is missing; the next ones are not
        print(f"the page: {problem!r}", file=sys.stderr)
    with suppress(InvalidStateError):  # the page that asked may be gone
        computed.set_result(text)
