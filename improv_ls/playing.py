"""The programs that play and their preparation, and the state of the performance according to the stage that leads."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from improv_core.diagnostics import Severity
from improv_core.ide.selection import Selection, UnplayableError
from improv_core.preview.replaying import followed, note
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.report import summary
from improv_core.protocol.messages import Sensed, State, TransportMessage
from improv_core.protocol.transport import beat_at
from improv_core.score.replay import Replay
from improv_core.score.score import Score
from improv_core.score.takeover import joined
from improv_ls.documents import Document, moved

if TYPE_CHECKING:
    from improv_core.ide.inlay_hint import Hint


Choose: TypeAlias = Callable[[Analysis], Selection]
"""Selects a part of a program. Raises UnplayableError."""


class PreparedProgram(NamedTuple):
    """A document whose analysis plays only the selection, and its score."""

    document: Document
    only: Selection
    score: Score

    def line(self) -> str:
        """Return a line that sums it up. This may take long."""
        told = summary(self.only.analysis)
        return f"{self.only.name}: {told}" if self.only.name else told


def prepare(document: Document, choose: Choose | None) -> PreparedProgram:
    """Prepare a part of a document, or without a choice all of it, which may take long. Raises UnplayableError with a
    reason in one line."""
    only = choose(document.analysis) if choose else Selection("", document.analysis)
    if why := refusal(document, whole=choose is None):
        raise UnplayableError(why)
    return PreparedProgram(replace(document, analysis=only.analysis), only, score_of(only.analysis))


def among(prepared: PreparedProgram, score: Score, before: Selection) -> PreparedProgram:
    """Return a part of a program that plays as this score, which may also have robots of the selection `before` it."""
    only, others = prepared.only, score.parts.keys() - prepared.score.parts.keys()
    ghost = only.ghost or (before.ghost if before.ghost in others else None)
    both = replace(only, ghost=ghost, moved=only.moved or (before.moved and bool(others)))
    return prepared._replace(score=score, only=both)


def refusal(document: Document, *, whole: bool) -> str | None:
    """Return why no robot may move because of `improv.toml` or, if the whole program is to play, of its errors."""
    analysis = document.analysis
    if not analysis.config.ok:
        # Without a text, editors can't show the errors.
        return "improv.toml has errors" if analysis.config.text else analysis.config.diagnostics[0].message
    errors = [each for each in analysis.diagnostics if each.severity is Severity.ERROR] if whole else []
    if not errors:
        return None
    line = document.lines.number(errors[0].span.start)
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"line {line}: {errors[0].message}{more}"


class Playing:
    """The state of the performance. `documents` are the open ones, in their current versions."""

    def __init__(self, documents: Mapping[str, Document]) -> None:
        self._documents = documents
        self._sent: dict[
            int, PreparedProgram
        ] = {}  # by generation: the one that plays, and those that are to take over
        self.latest: PreparedProgram | None = None
        """The program that was sent to the stages last."""
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
    def resumes(self) -> Mapping[str, float]:
        """The beats at which people may resume after a stop that nobody asked for: that of the scene, and the last."""
        found = self.transport.get("resumes") if self.transport else None
        return {"scene": found["scene"], "beat": found["beat"]} if found else {}

    @property
    def document(self) -> Document | None:
        """The document that plays, as it was when it was sent."""
        sent = self._sent.get(self.generation)
        return sent and sent.document

    def now(self, played: Document) -> Document:
        """Return the editor's current version of a document that was sent."""
        return self._documents.get(played.uri, played)

    def sent(self, generation: int, prepared: PreparedProgram) -> None:
        """Note that a program was sent to the stages; a message of the stages reports when it plays."""
        self._sent[generation] = self.latest = prepared

    def is_old(self, message: TransportMessage) -> bool:
        """Return whether a message is from a stage that has been replaced. It can be slow to stop, and the score of the
        new one has a higher generation."""
        return message["generation"] < self.generation

    def follow(self, message: TransportMessage) -> None:
        """Note a message of the stage."""
        generation, before = message["generation"], self.transport
        self.generation, self.transport = generation, message
        if not self.latest:
            return
        self._sent.setdefault(generation, self.latest)  # the page restarts it
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

        def renamed(sent: PreparedProgram) -> PreparedProgram:
            return sent._replace(document=replace(sent.document, uri=moved(sent.document.uri, old, new)))

        self._sent = {number: renamed(sent) for number, sent in self._sent.items()}
        self.latest = self.latest and renamed(self.latest)
