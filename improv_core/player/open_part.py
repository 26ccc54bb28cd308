"""A robot's part of a scene, performed step by step, since senses or joints decide it. It never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

from improv_core.player.setpoint_queue import SHORTEST
from improv_core.score.budget import Budget, TooLongError
from improv_core.score.movement import ENDLESS, FINEST, Duration, Exact, Movement, Velocity, exact
from improv_core.score.performer import Performer, performer_at
from improv_core.score.performing import Decision
from improv_core.score.transport import Transport

MAX_CHANGES = 10_000
"""The most changes of a part before time passes: more would make all robots late."""


class TooManyChangesError(Exception):
    """A part changes too often to be performed."""


class OpenPart:
    """A movement that began at a beat. `sensed` returns the present value of a sense; None if it is silent.

    If it reads a silent sense, nothing is decided, and the robot stands still while its beats keep counting. If it
    `has_poses`, each moment depends on where joints stand when it begins.
    """

    def __init__(
        self, movement: Movement, begins: Exact, sensed: Callable[[str], bool | None], has_poses: bool = False
    ) -> None:
        self._movement, self._begins, self._has_poses = movement, begins, has_poses
        self._performer = Performer(movement, begins)
        self._sensed = sensed
        self._has_skipped = False  # to where it has yet to be performed
        self.due: Duration = begins
        """The beat at which to perform it next."""
        self.has_begun = False
        """True once it has been performed."""

    @property
    def beat(self) -> Exact:
        """The beat up to which it has been performed."""
        return self._performer.beat

    @property
    def is_over(self) -> bool:
        return self._performer.is_over

    @property
    def velocity(self) -> Velocity:
        """The velocity until something changes."""
        return self._performer.performed(self._sensed)[0]

    def next_after(self, beat: Exact) -> Exact:
        """The beat at which an edge that came at `beat` takes effect: what has been performed can't be changed."""
        if not self.has_begun:
            return max(beat, self._begins)
        return max(beat, exact(Fraction(math.floor(self.beat * FINEST) + 1, FINEST)))

    def skip(self, beat: Exact, budget: Budget) -> None:
        """Move to a beat as if no sense was true until then. If that takes too long to compute, begin there."""
        self._has_skipped = True
        try:
            self._performer = performer_at(self._movement, self._begins, beat, budget)
        except TooLongError:
            self._performer = Performer(self._movement, beat)

    def plan(self, transport: Transport, performed: float, limit_at: float = math.inf) -> float:
        """Return when to perform it next, after this performance time: at its next change or when a joint reaches its
        limit, but not too soon, except after a jump. Prepares for that, if possible."""
        if not self._has_poses:
            self._performer.foresee()
        self.due = self._performer.until
        changes = transport.end(self.due)
        due = max(min(changes, limit_at), performed + (0.0 if self._has_skipped else float(SHORTEST)))
        self._has_skipped = False
        if due != changes:
            at = transport.beat(transport.clock(due), ENDLESS)
            self.due = min(at, self.due) if due < changes else max(at, self.due)
        return due

    def perform(self, beat: Exact) -> list[Decision]:
        """Perform up to a beat, by the present senses. Raises TooManyChangesError."""
        decisions: list[Decision] = []
        if self.is_over:  # a jump has led past its end
            return decisions
        for _ in range(MAX_CHANGES):
            if self.has_begun and self.beat < beat:
                until = min(self._performer.until, beat)
                assert not isinstance(until, float)
                self._performer.advance(until)
            self.has_begun = True
            decisions += self._performer.settle(self._sensed)
            if self.is_over or self.beat >= beat:
                return decisions
        raise TooManyChangesError
