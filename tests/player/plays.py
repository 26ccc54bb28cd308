"""Scores for a player, as a stage gets them."""

from __future__ import annotations

from typing import Any

from improv_core.protocol.messages import Load, Play, When
from improv_core.score.score import Score


def to_play(score: Score, generation: int = 1, when: When = "restart", **fields: Any) -> Play:
    """Return a message to play a score, with further fields unless they are None."""
    load: Load = {"type": "load", "generation": generation, "score": {}, "when": when, "backend": ""}
    load.update({name: value for name, value in fields.items() if value is not None})  # type: ignore[typeddict-item]
    return Play(load, score)
