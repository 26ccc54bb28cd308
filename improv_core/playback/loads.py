"""Scores as each stage is sent them: without the parts and movements that it has. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass

from improv_core.playback.stops import Receiver
from improv_core.score.score import Score
from improv_core.score.score_json import RowsWritten, to_json
from improv_core.stage.messages import Load, When


@dataclass(frozen=True, slots=True)
class Asked:
    """A score that somebody asked for; `stops` is the count of stops at that moment."""

    score: Score
    generation: int
    when: When
    beats_per_bar: int
    stops: int


class Loads:
    """Makes the messages that have stages play scores, and remembers what each stage has been sent."""

    def __init__(self) -> None:
        self._written: dict[Receiver, RowsWritten] = {}

    def make(self, stage: Receiver, asked: Asked, backend: str) -> Load:
        """The message to a stage; `backend` is what everything plays on, in words. It has to be sent, or forgotten."""
        written = self._written[stage] = self._written.get(stage, RowsWritten()).renewed()
        return {
            "type": "load",
            "generation": asked.generation,
            "score": to_json(asked.score, written),
            "when": asked.when,
            "backend": backend,
            "beats_per_bar": asked.beats_per_bar,
        }

    def forget(self, stage: Receiver) -> None:
        """Forget what a stage has: that is unknown, or it is gone. The next message has the whole score."""
        self._written.pop(stage, None)
