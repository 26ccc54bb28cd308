"""What plays now, according to the stage that leads, and the documents that it was made from."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from improv_core.ide.inlay_hint import Hint
from improv_core.ide.inlay_hint_playing import playing_hints
from improv_core.ide.moments import SoFar
from improv_core.score.movement import near
from improv_core.score.performance import SenseEdge
from improv_core.stage.messages import SceneJson, Sensed, State, TransportMessage, beat_at
from improv_ls.documents import Document, moved


class Playing:
    """What plays. `documents` are the open ones, as they are now."""

    def __init__(self, documents: Mapping[str, Document]) -> None:
        self._documents = documents
        self._sent: dict[int, Document] = {}  # by generation: the one that plays, and those that are to take over
        self._edges: list[SenseEdge] = []  # what has been sensed since this scene began
        self.latest: Document | None = None
        """What was sent to the stages last."""
        self.generation = 0
        self.state: State = "stopped"
        self.transport: TransportMessage | None = None
        """The latest one; None if no stage is there."""
        self.so_far = SoFar(edges=self._edges)
        """How what plays has been performed."""

    @property
    def document(self) -> Document | None:
        """The document that plays, as it was when it was sent."""
        return self._sent.get(self.generation)

    def now(self, played: Document) -> Document:
        """A document that was sent, as it is in the editor now."""
        return self._documents.get(played.uri, played)

    def sent(self, generation: int, document: Document) -> None:
        """A document was sent to the stages, and will play once they say so."""
        self._sent[generation] = self.latest = document

    def is_old(self, message: TransportMessage) -> bool:
        """Whether a message is from a stage that has been replaced. It can be slow to stop, and what the new one plays
        has a higher generation."""
        return message["generation"] < self.generation

    def follow(self, message: TransportMessage) -> Literal["program", "scene"] | None:
        """Note what the stage says. Returns what began: another program, or another scene of this one."""
        generation, before = message["generation"], self.generation
        self.state, self.generation, self.transport = message["state"], generation, message
        scene = message.get("scene") or SceneJson(index=0, begins=0.0)
        so_far = SoFar(message.get("begins", {}), scene["index"], scene["begins"], self._edges)
        if generation == before and self.so_far == so_far and message["beat"]:
            return None  # it continues from there
        self._edges = []
        self.so_far = replace(so_far, edges=self._edges)
        if generation == before:
            return "scene"
        if not self.latest:
            return None
        self._sent.setdefault(generation, self.latest)  # the page restarts it
        self._sent = {number: document for number, document in self._sent.items() if number >= generation}
        return "program"

    def sensed(self, message: Sensed) -> None:
        """Note a change of a robot's sense."""
        self._edges.append(SenseEdge(near(message["beat"]), message["robot"], message["sense"], message["value"]))

    def gone(self) -> None:
        """Note that the stage has ended, and nothing plays."""
        self.state, self.transport = "stopped", None

    def hints(self, uri: str) -> Sequence[Hint]:
        """The inlay hints of a document about what plays now."""
        if not self.transport or not self.document or self.document.uri != uri:
            return ()
        return self.hints_at(beat_at(self.transport, time.monotonic()))

    def hints_at(self, beat: float) -> Sequence[Hint]:
        """The inlay hints of the document that plays, at a beat."""
        played = self.document
        if not played or self.state not in ("playing", "paused"):
            return ()
        return playing_hints(played.analysis, self.now(played).analysis, beat, self.so_far)

    def renamed(self, old: str, new: str) -> None:
        """Note that the file that was played, or a folder around it, has another name now."""
        self._sent = {
            number: replace(document, uri=moved(document.uri, old, new)) for number, document in self._sent.items()
        }
        if self.latest:
            self.latest = replace(self.latest, uri=moved(self.latest.uri, old, new))
