"""Messages for editors that light up the words that play (docs/protocol.md); sent only on request.

The server keeps the time, so that no editor needs a clock: it sends the lit words and the beat whenever they change.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Mapping
from typing import Any

from improv_core.ide.moments import Places, lit_words
from improv_core.protocol.commands import is_muted
from improv_core.protocol.messages import TransportMessage
from improv_core.protocol.transport import beat_at, counted, silenced
from improv_core.score.movement import Duration
from improv_core.session.state import SessionState
from improv_core.text import Span
from improv_ls.documents import Document
from improv_ls.editor import Editor
from improv_ls.playing import Playing
from improv_ls.positions import to_position

LIT = "improv/lit"
TRANSPORT = "improv/transport"
EVALUATED = "improv/evaluated"
PASSED_ON = {"state", "backend", "generation", "tempo", "speed", "beats", "muted", "soloed"}
"""The parts of the stage's messages that editors get."""
SHORTEST = 0.03
"""Seconds between two changes of the lit words, at least: nobody sees shorter ones."""
SHORTEST_BEAT = 0.25
"""Seconds between two messages about the beat, at least: nobody reads faster."""
AFTER = 0.002
"""Seconds to wait after the time of a change, so that it surely has come."""

Range = tuple[int, int, int, int]


class Live:
    """Sends these messages. `state` returns the state of the session."""

    def __init__(self, editor: Editor, playing: Playing, state: Callable[[], SessionState]) -> None:
        self._editor = editor
        self._playing = playing
        self._state = state
        self._framed = 0  # the number of pages in a frame, which ends with the editor's window
        self._timer: asyncio.TimerHandle | None = None  # runs until the lit words, or the beat, change
        self._lit: Mapping[str, Any] = {"ranges": []}  # as sent last
        self._counted = ""  # as sent last,
        self._counted_at = 0.0  # at this time
        self._played: Document | None = None  # the values below are for this document as it plays,
        self._known: Document | None = None  # and as it is now
        self._places: Places | None = None  # of the words that play

    def follow(self, message: TransportMessage) -> None:
        """Send the new state of the stage, and from now on its changes as time passes."""
        if self._editor.takes_own_messages:
            self._tell(message, time.monotonic(), changed=True)

    def framed(self, pages: int) -> None:
        """Send the number of pages in a frame at once."""
        self._framed = pages
        if message := self._playing.transport:
            self.follow(message)

    def sensed(self) -> None:
        """Check soon for other words to light, because a sense has changed."""
        if self._timer:
            self._tell_in(SHORTEST)

    def evaluated(self, document: Document, span: Span) -> None:
        """Send that this part of a document was just played."""
        if self._editor.takes_own_messages and document.version is not None:
            told = {"uri": document.uri, "version": document.version, "range": self._range(document, span)}
            self._notify(EVALUATED, told)

    def stop(self) -> None:
        """Send that no words are lit anymore, and nothing further."""
        if self._timer:
            self._timer.cancel()
            self._timer = None
        self._light([])

    def _tell_in(self, seconds: float) -> None:
        """Send the changes after this time, or earlier if a timer is about to do so."""
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
        """Send the lit words, and the position if that `changed` or another beat has begun; then wait for the next
        change."""
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
        """Send the words that are lit at a beat. Return the beat until which they stay lit; None if nothing changes."""
        played, replay = self._playing.document, self._playing.replay
        if not played or not replay or message["state"] not in ("playing", "paused"):
            self._light([])
            return None
        document = self._playing.now(played)
        if not self._places or document is not self._known or played is not self._played:
            self._played, self._known = played, document
            self._places = Places(played.analysis, document.analysis)
        muted, soloed = message["muted"], message["soloed"]
        spans, until = lit_words(replay, beat, self._places, lambda robot: is_muted(robot, muted, soloed))
        self._light(spans)
        return until

    def _light(self, spans: list[Span]) -> None:
        """Send the lit words, if the editor doesn't know them."""
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
        start, end = (to_position(document.lines, offset, self._editor.encoding) for offset in span)
        return start.line, start.character, end.line, end.character

    def _tell_transport(self, message: TransportMessage, beat: float) -> None:
        document, self._counted, state = self._playing.document, counted(message, beat), self._state()
        told = {
            **{name: value for name, value in message.items() if name in PASSED_ON},
            "beat": beat,
            "counted": self._counted,
            "silenced": silenced(message["muted"], message["soloed"]),
            "robots": sorted(self._playing.replay.score.parts) if self._playing.replay else [],
            "uri": document.uri if document else None,
            "page": state.page,
            "framed": self._framed,
            "real": state.is_real,
        }
        self._notify(TRANSPORT, told)

    def _notify(self, method: str, params: Mapping[str, Any]) -> None:
        self._editor.server.protocol.notify(method, params)
