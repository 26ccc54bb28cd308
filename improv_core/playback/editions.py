"""Which parts a save leaves as they are: those get the edition of a part that may still play. Standard library only."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from improv_core.score.equality import same
from improv_core.score.score import Part, Score

MOST_SENT = 100
"""Scores to compare with. Hundreds of saves may wait for the end of a long dance, of which only the last will play."""


class Editions:
    """Numbers the parts of the scores that are sent, so that stages need not compare them.

    What is compared is what may play when a score takes over: the last score that was reported to play, and all that
    were sent since.
    """

    def __init__(self) -> None:
        self._latest = 0
        self._sent: dict[int, Score] = {}  # by generation, oldest first

    def number(self, score: Score, generation: int) -> Score:
        """The same score with the editions of its parts; `generation` counts scores."""
        known: dict[str, dict[int, Part]] = {}
        for earlier in reversed(self._sent.values()):
            for robot in earlier.parts.keys() & score.parts.keys():
                known.setdefault(robot, {}).setdefault(earlier.parts[robot].edition, earlier.parts[robot])
        numbered = {
            robot: replace(part, edition=self._edition(part, known.get(robot, {}).values()))
            for robot, part in score.parts.items()
        }
        self._sent[generation] = replace(score, parts=numbered)
        if len(self._sent) > MOST_SENT:
            del self._sent[list(self._sent)[1]]  # the first one plays
        return self._sent[generation]

    def plays(self, generation: int) -> None:
        """A stage has reported that a score plays, so the ones before it do not matter any more."""
        if generation in self._sent:
            self._sent = {number: score for number, score in self._sent.items() if number >= generation}

    def _edition(self, part: Part, known: Iterable[Part]) -> int:
        for earlier in known:
            if _are_alike(earlier, part):
                return earlier.edition
        self._latest += 1
        return self._latest


def _are_alike(one: Part, other: Part) -> bool:
    """Whether two parts of a robot move it alike; the message's type is in the profile."""
    return one.topic == other.topic and one.profile == other.profile and same(one.movement, other.movement)
