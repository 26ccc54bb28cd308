"""Which parts a save leaves as they are: those get the edition of a part that may still play. Standard library only.

Scenes are compared one by one: a part that is the same in the scene that plays is left alone, whatever comes later.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from improv_core.score.equality import same
from improv_core.score.movement import Movement
from improv_core.score.score import UNNUMBERED, Part, Score

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
        numbered = {robot: replace(part, editions=self._editions(part)) for robot, part in score.parts.items()}
        self._sent[generation] = replace(score, parts=numbered)
        if len(self._sent) > MOST_SENT:
            del self._sent[list(self._sent)[1]]  # the first one plays
        return self._sent[generation]

    @property
    def may_play(self) -> Collection[Score]:
        """The scores that may play now, oldest first."""
        return self._sent.values()

    def plays(self, generation: int) -> None:
        """Note that a stage has reported that a score plays, so the ones before it no longer matter."""
        if generation in self._sent:
            self._sent = {number: score for number, score in self._sent.items() if number >= generation}

    def _editions(self, part: Part) -> tuple[int, ...]:
        """A number for each scene: that of an earlier part if it moves the robot in the same way in that scene."""
        earlier = [
            known
            for score in reversed(self._sent.values())
            if (known := score.parts.get(part.robot)) and (known.topic, known.profile) == (part.topic, part.profile)
        ]
        return tuple(
            self._edition(scene, {known.edition(index): known.of_scene(index) for known in earlier})
            for index, scene in enumerate(part.scenes)
        )

    def _edition(self, scene: Movement, known: Mapping[int, Movement]) -> int:
        for edition, movement in known.items():
            if edition != UNNUMBERED and same(movement, scene):
                return edition
        self._latest += 1
        return self._latest
