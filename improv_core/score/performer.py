"""Performs an open movement, one whose moments depend on what its robot senses. Standard library only.

A closed movement is walked ahead (walk.py). An open one can't be: a performer gets the values of senses as time passes,
and knows the robot's velocity until the next change that is certain. It never reads a clock.
"""

from __future__ import annotations

from copy import copy

from improv_core.score.budget import Budget
from improv_core.score.movement import STILL, Around, Duration, Exact, Movement
from improv_core.score.performing import Decision, Performed, Sensed, UnforeseenError, begin
from improv_core.score.throws import ROBOTS, dice_of

MAX_SKIPPED = 1_000
"""The most changes of all robots that are performed to find what plays at a beat that playback jumps to."""


class Performer:
    """The performance of a movement for one robot, from its beat `start` on, which is `beat` of the performance.

    Beats are those of the performance. Up to the start, it is as if no sense had been true: raises UnforeseenError if
    that has to be performed to be known. Call `settle` when something may have changed, then read the properties, then
    call `advance`.
    """

    def __init__(self, movement: Movement, beat: Exact = 0, start: Duration = 0) -> None:
        self._execution = begin(movement, dice_of(ROBOTS) if movement.dice else None, Around(), start)
        self._missed: set[str] = set()  # senses that were silent when something had to be decided by them
        self.beat = beat
        """The beat up to which it has been performed."""

    def settle(self, sensed: Sensed) -> list[Decision]:
        """Do everything that takes no time: begin what begins now, and read the senses that are watched now."""
        decisions: list[Decision] = []
        unheard: set[str] = set()

        def ask(sense: str) -> bool | None:
            value = sensed(sense)
            if value is None:
                unheard.add(sense)
            return value

        while not self._execution.is_over(self.beat) and (decision := self._execution.read(ask, self.beat)):
            decisions.append(decision)
        if any(not decision.held for decision in decisions):
            self._missed |= unheard
        return decisions

    @property
    def is_over(self) -> bool:
        """True if nothing is left to perform."""
        return self._execution.is_over(self.beat)

    @property
    def until(self) -> Duration:
        """The beat of the next change, if no sense changes before."""
        return self.beat + self._execution.left()

    def performed(self, sensed: Sensed) -> Performed:
        """The velocity and the words until then. If it reads a silent sense, the robot stands, and no word plays."""
        self._missed = {sense for sense in self._missed if sensed(sense) is None}
        waits = self._missed or any(sensed(sense) is None for sense in self.watched())
        return (STILL, ()) if waits else self._execution.velocity()

    def watched(self) -> frozenset[str]:
        """Return the senses that may change that."""
        return frozenset(self._execution.watched())

    def advance(self, beat: Exact) -> None:
        """Perform up to a beat, `until` at the latest."""
        if passed := beat - self.beat:
            self._execution.pass_time(passed)
            self.beat = beat

    def foresee(self) -> None:
        """Compute what comes next before its time, if no sense decides it. Don't call this with poses, which depend on
        where joints stand then."""
        self._execution.foresee()

    def fork(self) -> Performer:
        """Return a copy of this performance, which continues by itself."""
        fork = copy(self)
        fork._execution = self._execution.fork()
        return fork


def performer_at(movement: Movement, begins: Exact, beat: Exact, budget: Budget) -> Performer:
    """Return the performance of a movement that begins at `begins`, at a later beat, if no sense is true until then.

    If the performance is over before that beat, it stays at its end. Raises TooLongError if it would have to be
    performed for too long.
    """
    passed = min(beat - begins, movement.duration)
    assert not isinstance(passed, float)
    try:
        return Performer(movement, begins + passed, passed)
    except UnforeseenError:
        performer = Performer(movement, begins)
        while True:
            performer.settle(_never)
            if performer.is_over or performer.beat >= beat:
                return performer
            budget.spend()
            until = min(performer.until, beat)
            assert not isinstance(until, float)
            performer.advance(until)


def _never(sense: str) -> bool:
    return False
