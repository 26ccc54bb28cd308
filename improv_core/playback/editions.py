"""Which parts a save leaves as they are: those get the edition of a part that may still play. Standard library only."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from improv_core.score.movement import Gain, Hold, Movement, Pace, Repeat, Use, parts
from improv_core.score.score import Part, Score


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


def same(one: Movement, other: Movement) -> bool:
    """Whether two movements are the same apart from places in the text. Each pair of them is compared once."""
    compared: set[tuple[int, int]] = set()
    waiting = [(one, other)]
    while waiting:
        a, b = map(_within_names, waiting.pop())
        if a is b or (id(a), id(b)) in compared:
            continue
        if type(a) is not type(b) or a.duration != b.duration or _own(a) != _own(b):
            return False
        inner = parts(a), parts(b)
        if len(inner[0]) != len(inner[1]):
            return False
        compared.add((id(a), id(b)))
        waiting += zip(*inner, strict=True)
    return True


def _within_names(movement: Movement) -> Movement:
    while isinstance(movement, Use):
        movement = movement.body
    return movement


def _own(movement: Movement) -> object:
    """What a movement has besides those in it."""
    if isinstance(movement, Hold):
        return movement.velocity
    if isinstance(movement, Repeat):
        return movement.times
    if isinstance(movement, Pace):
        return movement.rate
    return movement.gain if isinstance(movement, Gain) else None
