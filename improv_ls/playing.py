"""The state of the performance, according to the stage that leads, and the documents of its scores."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from improv_core.preview.replaying import followed, note
from improv_core.protocol.messages import Sensed, State, TransportMessage
from improv_core.protocol.transport import beat_at
from improv_core.score.replay import Replay
from improv_core.score.score import Score
from improv_core.score.takeover import joined
from improv_ls.documents import Document, moved

if TYPE_CHECKING:
    from improv_core.ide.inlay_hint import Hint


class _Sent(NamedTuple):
    document: Document
    score: Score


class Playing:
    """The state of the performance. `documents` are the open ones, in their current versions."""

    def __init__(self, documents: Mapping[str, Document]) -> None:
        self._documents = documents
        self._sent: dict[int, _Sent] = {}  # by generation: the one that plays, and those that are to take over
        self._latest: _Sent | None = None
        self._began: object = None  # the generation, and the times at which its parts began
        self.replay: Replay | None = None
        """The replay of the robots; None before anything has played."""
        self.generation = 0
        self.transport: TransportMessage | None = None
        """The latest transport message; None if there is no stage."""

    @property
    def state(self) -> State:
        return self.transport["state"] if self.transport else "stopped"

    @property
    def latest(self) -> Document | None:
        """The document that was sent to the stages last."""
        return self._latest and self._latest.document

    @property
    def document(self) -> Document | None:
        """The document that plays, as it was when it was sent."""
        sent = self._sent.get(self.generation)
        return sent and sent.document

    def now(self, played: Document) -> Document:
        """Return the editor's current version of a document that was sent."""
        return self._documents.get(played.uri, played)

    def sent(self, generation: int, document: Document, score: Score) -> None:
        """Note that a document was sent to the stages as this score; a message of the stages reports when it plays."""
        self._sent[generation] = self._latest = _Sent(document, score)

    def is_old(self, message: TransportMessage) -> bool:
        """Return whether a message is from a stage that has been replaced. It can be slow to stop, and the score of the
        new one has a higher generation."""
        return message["generation"] < self.generation

    def follow(self, message: TransportMessage) -> None:
        """Note a message of the stage."""
        generation, before = message["generation"], self.transport
        self.generation, self.transport = generation, message
        if not self._latest:
            return
        self._sent.setdefault(generation, self._latest)  # the page restarts it
        self._sent = {number: sent for number, sent in self._sent.items() if number >= generation}
        began = generation, message.get("begins"), message.get("scene")
        known = self.replay.score if self.replay and began == self._began else None
        score = known or joined(self._sent[generation].score, message)
        self.replay, self._began = followed(self.replay, score, before, message), began

    def sensed(self, message: Sensed) -> None:
        """Note a change of a robot's sense."""
        if self.replay:
            note(self.replay, message)

    def gone(self) -> None:
        """Note that the stage has ended, and nothing plays."""
        self.transport = None

    def hints(self, uri: str) -> Sequence[Hint]:
        """Return the inlay hints of a document at the current position."""
        if not self.transport or not self.document or self.document.uri != uri:
            return ()
        return self.hints_at(beat_at(self.transport, time.monotonic()))

    def hints_at(self, beat: float) -> Sequence[Hint]:
        """Return the inlay hints of the document that plays, at a beat."""
        played = self.document
        if not played or not self.replay or self.state not in ("playing", "paused"):
            return ()
        from improv_core.ide.inlay_hint import playing_hints  # here, since robots can start without it

        return playing_hints(self.replay, self.now(played).analysis, beat)

    def renamed(self, old: str, new: str) -> None:
        """Note that the file that was played, or a folder around it, has a new name."""

        def renamed(sent: _Sent) -> _Sent:
            return sent._replace(document=replace(sent.document, uri=moved(sent.document.uri, old, new)))

        self._sent = {number: renamed(sent) for number, sent in self._sent.items()}
        self._latest = self._latest and renamed(self._latest)
