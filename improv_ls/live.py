"""Messages of our own, for editors that light what is playing (docs/protocol.md); sent only on request.

The server keeps the time, so that no editor needs a clock: it says what is lit and which beat it is whenever that
changes.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

from improv_core.ide.moments import Places, lit_words
from improv_core.protocol.messages import TransportMessage, beat_at, counted, is_silent
from improv_core.score.movement import Duration
from improv_core.session.state import SessionState
from improv_core.text import Span
from improv_ls.documents import Document
from improv_ls.editor import Editor
from improv_ls.playing import Playing
from improv_ls.positions import to_position

LIT = "improv/lit"
TRANSPORT = "improv/transport"
SHORTEST = 0.03
"""Seconds between two changes of what is lit, at least: nobody sees shorter ones."""
SHORTEST_BEAT = 0.25
"""Seconds between two messages about the beat, at least: nobody reads faster."""
AFTER = 0.002
"""Seconds to wait after the time of a change, so that it surely has come."""

Range = tuple[int, int, int, int]


class Live:
    """Sends these messages. `state` returns the state of the session, if anything has played."""

    def __init__(self, editor: Editor, playing: Playing, state: Callable[[], SessionState | None]) -> None:
        self._editor = editor
        self._playing = playing
        self._state = state
        self._framed = 0  # how many pages are in a frame, which ends with the editor's window
        self._timer: asyncio.TimerHandle | None = None  # what is lit, or the beat, is about to change
        self._lit: Mapping[str, Any] = {"ranges": []}  # as told last
        self._counted = ""  # as told last,
        self._counted_at = 0.0  # at this time
        self._played: Document | None = None  # of what plays and of how its document is now, this is known:
        self._known: Document | None = None
        self._places: Places | None = None  # of the words that play
        self._ranges: dict[Span, Range] = {}

    def follow(self, message: TransportMessage) -> None:
        """Tell what the stage says, and from now on what changes as time passes."""
        if self._editor.takes_own_messages:
            self._tell(message, time.monotonic(), changed=True)

    def framed(self, pages: int) -> None:
        """Tell at once how many pages are in a frame now."""
        self._framed = pages
        if message := self._playing.transport:
            self.follow(message)

    def sensed(self) -> None:
        """What robots sense may have changed what plays."""
        if self._timer:
            self._tell_in(SHORTEST)

    def stop(self) -> None:
        """Tell that nothing is lit any more, and nothing further."""
        if self._timer:
            self._timer.cancel()
            self._timer = None
        self._light([])

    def _tell_in(self, seconds: float) -> None:
        """Tell what has changed by then, or earlier if that was about to be told."""
        loop = asyncio.get_running_loop()
        at = loop.time() + seconds
        if self._timer:
            at = min(at, self._timer.when())
            self._timer.cancel()
        self._timer = loop.call_at(at, self._tell_changes)

    def _tell_changes(self) -> None:
        self._timer = None
        if message := self._playing.transport:
            self._tell(message, time.monotonic())

    def _tell(self, message: TransportMessage, now: float, changed: bool = False) -> None:
        """Tell what is lit now, and the position if that `changed` or another beat has begun; wait for what is next."""
        beat = beat_at(message, now)
        until = self._light_at(message, beat)
        if changed or (now >= self._counted_at + SHORTEST_BEAT and counted(message, beat) != self._counted):
            self._tell_transport(message, beat)
            self._counted_at = now
        if self._timer:
            self._timer.cancel()
            self._timer = None
        if message["state"] == "playing":
            period = 60 / message["tempo"]
            counts = max((int(beat) + 1 - beat) * period, self._counted_at + SHORTEST_BEAT - now)
            changes = math.inf if until is None else max((float(until) - beat) * period, SHORTEST)
            self._tell_in(min(counts, changes) + AFTER)

    def _light_at(self, message: TransportMessage, beat: float) -> Duration | None:
        """Tell what is lit at a beat. Returns the beat until which that is so; None if nothing changes."""
        played, replay = self._playing.document, self._playing.replay
        if not played or not replay or message["state"] not in ("playing", "paused"):
            self._light([])
            return None
        document = self._playing.now(played)
        if not self._places or document is not self._known or played is not self._played:
            self._played, self._known, self._ranges = played, document, {}
            self._places = Places(played.analysis, document.analysis)
        muted, soloed = message["muted"], message["soloed"]
        spans, until = lit_words(replay, beat, self._places, lambda robot: is_silent(robot, muted, soloed))
        self._light(spans)
        return until

    def _light(self, spans: list[Span]) -> None:
        """Tell which words are lit, if the editor doesn't know that."""
        document = self._known
        if not document or document.version is None:
            return
        ranges = [self._range(document, span) for span in spans]
        told = {"uri": document.uri, "version": document.version, "ranges": ranges}
        if not ranges and not self._lit["ranges"]:
            return
        if self._lit["ranges"] and self._lit["uri"] != document.uri:
            self._notify(LIT, {**self._lit, "ranges": []})
        if told != self._lit:
            self._lit = told
            self._notify(LIT, told)

    def _range(self, document: Document, span: Span) -> Range:
        if span not in self._ranges:
            start, end = (to_position(document.lines, offset, self._editor.encoding) for offset in span)
            self._ranges[span] = start.line, start.character, end.line, end.character
        return self._ranges[span]

    def _tell_transport(self, message: TransportMessage, beat: float) -> None:
        document, self._counted, state = self._playing.document, counted(message, beat), self._state()
        told = {
            "state": message["state"],
            "backend": message["backend"],
            "generation": message["generation"],
            "tempo": message["tempo"],
            "speed": message["speed"],
            "beats": message["beats"],
            "beat": beat,
            "counted": self._counted,
            "muted": message["muted"],
            "soloed": message["soloed"],
            "robots": sorted(self._playing.replay.score.parts) if self._playing.replay else [],
            "uri": document.uri if document else None,
            "page": state.page if state else None,
            "framed": self._framed,
            "real": state is not None and state.is_real,
        }
        self._notify(TRANSPORT, told)

    def _notify(self, method: str, params: Mapping[str, Any]) -> None:
        self._editor.server.protocol.notify(method, params)
