"""Messages of our own, for editors that highlight what is playing (docs/protocol.md); sent only on request."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal

from improv_core.ide.moments import playing
from improv_core.stage.messages import TransportMessage, beat_at
from improv_core.text import Span
from improv_ls.documents import Document
from improv_ls.editor import Editor
from improv_ls.playing import Playing
from improv_ls.positions import Encoding, to_position
from improv_ls.settling import Settling

EVALUATED = "improv/evaluated"
TRANSPORT = "improv/transport"
TRANSPORT_PERIOD = 1.0
"""Seconds between two messages that tell which beat is playing."""
DECIDED_PERIOD = 0.03
"""Seconds in which what senses decide is collected before the editor is told."""


class Live:
    """Sends these messages. `page` returns the URL of the simulator's page if there is one."""

    def __init__(self, editor: Editor, playing: Playing, settling: Settling, page: Callable[[], str | None]) -> None:
        self._editor = editor
        self._settling = settling
        self._playing = playing
        self._page = page
        self._decided: asyncio.TimerHandle | None = None  # what was decided is about to be told
        self._telling: asyncio.Task[None] | None = None
        self._began = False  # a program has, and the editor hasn't been told of it yet

    def moments(self, start: float) -> Mapping[str, Any]:
        """What plays from a beat on: ranges in the document as it is now, and for each robot when each of them plays.

        Empty if nothing was played.
        """
        played = self._playing.document
        if not played:
            return {}
        now, generation = self._playing.now(played), self._playing.generation
        indices: dict[Span, int] = {}
        robots = {
            robot: {
                "moments": [
                    [moment.start, moment.end, [indices.setdefault(span, len(indices)) for span in moment.spans]]
                    for moment in stretch.moments
                ],
                "until": stretch.until,
            }
            for robot, stretch in playing(played.analysis, now.analysis, start, self._playing.so_far).items()
        }
        encoding = self._editor.encoding
        ranges = [[value for offset in span for value in _position(now, offset, encoding)] for span in indices]
        return {
            "generation": generation,
            "uri": now.uri,
            "version": now.version,
            "from": start,
            "ranges": ranges,
            "robots": robots,
        }

    def follow(self, message: TransportMessage, began: Literal["program", "scene"] | None) -> None:
        """Report what began, and every second which beat is playing: clocks drift, and clients join late."""
        if self._telling:
            self._telling.cancel()
        if not self._editor.takes_own_messages:
            return
        if began == "program":
            self._began = True
        elif began == "scene":
            self.decided(message["beat"])
        self._telling = asyncio.create_task(self._keep_telling(message))

    def decided(self, beat: float) -> None:
        """Report soon what plays from a beat on, now that senses have decided something."""
        if self._editor.takes_own_messages and not self._decided:
            self._decided = asyncio.get_running_loop().call_later(DECIDED_PERIOD, self._tell_decided, beat)

    def stop(self) -> None:
        if self._decided:
            self._decided.cancel()
            self._decided = None
        if self._telling:
            self._telling.cancel()

    def _tell_decided(self, beat: float) -> None:
        self._decided = None
        self._editor.soon(self._evaluate(beat))

    async def _evaluate(self, beat: float) -> None:
        if found := await self._settling.run(partial(self.moments, beat)):
            self._notify(EVALUATED, found)

    async def _keep_telling(self, message: TransportMessage) -> None:
        if self._began:
            await self._evaluate(message["beat"])
            self._began = False
        while True:
            document = self._playing.document
            self._notify(TRANSPORT, _transport(message, document.uri if document else None, self._page()))
            if message["state"] != "playing":
                return
            await asyncio.sleep(TRANSPORT_PERIOD)

    def _notify(self, method: str, params: Mapping[str, Any]) -> None:
        self._editor.server.protocol.notify(method, params)


def _transport(message: TransportMessage, uri: str | None, page: str | None) -> dict[str, Any]:
    """A stage's transport message as of now."""
    return {
        "generation": message["generation"],
        "state": message["state"],
        "backend": message["backend"],
        "tempo": message["tempo"],
        "speed": message["speed"],
        "beats": message["beats"],
        "muted": message["muted"],
        "soloed": message["soloed"],
        "beat": beat_at(message, time.monotonic()),
        "wall": time.time(),
        "uri": uri,
        "page": page,
    }


def _position(document: Document, offset: int, encoding: Encoding) -> tuple[int, int]:
    position = to_position(document.lines, offset, encoding)
    return position.line, position.character
