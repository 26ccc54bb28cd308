"""Finds the parts that a save doesn't change: each gets the edition of a part that may still play. Standard library
only.

Scenes are compared one by one: a part that is the same in the scene that plays stays untouched, no matter what comes
later.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import count

from improv_core.score.equality import same
from improv_core.score.movement import Movement
from improv_core.score.score import UNNUMBERED, Part, Score

MOST_SENT = 100
"""The most scores to compare with. Hundreds of saves may wait for the end of a long dance, of which only the last will
play."""


@dataclass(frozen=True, slots=True)
class PartVersions:
    """Numbers the parts of the scores that are sent, so that stages need not compare them.

    `latest` is the highest number. `sent` has the scores that may play when another takes over, by generation, oldest
    first: the last score that a stage reported to play, and all later ones.
    """

    latest: int = 0
    sent: Mapping[int, Score] = field(default_factory=dict)

    def number(self, score: Score, generation: int) -> tuple[PartVersions, Score]:
        """Return the next editions, and the score with the editions of its parts; `generation` counts scores."""
        new = count(self.latest + 1)
        parts = {robot: replace(part, editions=self._editions(part, new)) for robot, part in score.parts.items()}
        score = replace(score, parts=parts)
        sent = {**self.sent, generation: score}
        if len(sent) > MOST_SENT:
            del sent[list(sent)[1]]  # the first one plays
        return PartVersions(next(new) - 1, sent), score

    def plays(self, generation: int) -> PartVersions:
        """Return it after a stage has reported that a score plays: the scores before it no longer matter."""
        if next(iter(self.sent), generation) == generation or generation not in self.sent:
            return self
        return replace(self, sent={number: score for number, score in self.sent.items() if number >= generation})

    def _editions(self, part: Part, new: Iterator[int]) -> tuple[int, ...]:
        """Return a number for each scene: that of an earlier part if it moves the robot in the same way in that
        scene."""
        earlier = [
            known
            for score in reversed([*self.sent.values()])
            if (known := score.parts.get(part.robot)) and known.profile == part.profile
        ]
        return tuple(
            next(_alike(scene, {known.edition(index): known.of_scene(index) for known in earlier}), None) or next(new)
            for index, scene in enumerate(part.scenes)
        )


def _alike(scene: Movement, known: Mapping[int, Movement]) -> Iterator[int]:
    return (edition for edition, movement in known.items() if edition != UNNUMBERED and same(movement, scene))
