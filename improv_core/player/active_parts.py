"""The parts that play in this scene, and the beats at which they are over. It never reads a clock.

A base's part is performed step by step if senses decide it. A body part's always is: it may depend on where the joints
stand.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from itertools import chain, islice, takewhile

from improv_core.player.open_part import OpenPart, TooManyChangesError
from improv_core.player.run import Run
from improv_core.player.setpoint_queue import Setpoint, setpoints, zeros
from improv_core.score.budget import Budget
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement
from improv_core.score.performance import Mover
from improv_core.score.performer import MAX_SKIPPED
from improv_core.score.performing import Decision
from improv_core.score.senses import RobotSense


class ActiveParts:
    """The parts of a scene. `value` returns what a robot senses now; None if that is unknown."""

    def __init__(self, value: Callable[[RobotSense], bool | None]) -> None:
        self._value = value
        self._budget = Budget(MAX_SKIPPED)  # for all parts that begin together
        self._over: dict[Mover, Duration] = {}  # the beat at which each part is over; ENDLESS if senses decide it
        self.over: Duration = 0
        """The beat at which the last part is over."""
        self.open: dict[Mover, OpenPart] = {}
        """The parts that are performed step by step, and are not over."""
        self.asked: tuple[RobotSense, ...] = ()
        """The senses that these parts read."""

    def dismiss(self, robots: Collection[str] | None = None) -> None:
        """Forget the parts of these robots, or all."""
        if robots is None:
            self.open, self._over, self.asked = {}, {}, ()
            return
        self.open = {mover: part for mover, part in self.open.items() if mover.robot not in robots}
        self._over = {mover: beat for mover, beat in self._over.items() if mover.robot not in robots}

    def begin(
        self, run: Run, mover: Mover, movement: Movement, beat: Exact, has_poses: bool = False
    ) -> OpenPart | None:
        """Begin a mover's movement of this scene from a beat on. Return its open part, if it has one."""
        begins = run.score.begins(mover.robot, run.scene)
        self._over[mover] = ENDLESS if movement.open else begins + movement.duration
        if not (movement.open or (mover.part and movement.duration)):
            return None
        if mover not in self.open:
            sensed = lambda sense: self._value(RobotSense(mover.robot, sense))  # noqa: E731
            self.open[mover] = OpenPart(movement, begins, sensed, has_poses)
            if begins < beat:
                self.open[mover].skip(beat, self._budget)
        self.open[mover].due = max(beat, begins)
        return self.open[mover]

    def complete(self, run: Run) -> None:
        """Note that all parts of the scene have begun."""
        self._budget = Budget(MAX_SKIPPED)
        self._find_end()
        robots = [mover.robot for mover in self.open if not mover.part]
        self.asked = tuple(RobotSense(robot, sense) for robot in robots for sense in run.score.parts[robot].senses)

    def open_of(self, robot: str) -> list[Mover]:
        """Return a robot's movers that have an open part, its base first."""
        return sorted(mover for mover in self.open if mover.robot == robot)

    def perform(self, mover: Mover, beat: Exact) -> list[Decision]:
        """Perform an open part up to a beat, and close it if it is over.

        Closes it and raises TooManyChangesError if it changes too often.
        """
        open_part = self.open[mover]
        try:
            decisions = open_part.perform(beat)
        except TooManyChangesError:
            self._close(mover)
            raise
        if open_part.is_over:
            self._close(mover)
        return decisions

    def _close(self, mover: Mover) -> None:
        self._over[mover] = self.open.pop(mover).beat
        self._find_end()

    def _find_end(self) -> None:
        self.over = max(self._over.values(), default=0)


class ComputedBeginning:
    """The first setpoints of parts that no sense decides, so that beat 0 doesn't wait for them."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._parts: dict[str, Iterator[Setpoint]] = {}

    def compute(self, run: Run) -> None:
        """Compute them for this run, unless that was done."""
        if not self._is_of(run):
            closed = [robot for robot, part in run.score.parts.items() if not part.of_scene(run.scene).open]
            self._run, self._parts = run, {robot: _with_first(closed_part(run, robot, 0)) for robot in closed}

    def part(self, run: Run, robot: str, beat: Exact) -> Iterator[Setpoint]:
        """Return the setpoints of a part from a beat on, as `closed_part` does."""
        known = self._parts.pop(robot, None) if beat == 0 and self._is_of(run) else None
        return known or closed_part(run, robot, beat)

    def _is_of(self, run: Run) -> bool:
        known = self._run
        return run.score is known.score and (run.scene, run.tempo) == (known.scene, known.tempo)


def _with_first(setpoints: Iterator[Setpoint]) -> Iterator[Setpoint]:
    """Return the same setpoints, the first of which is known at once."""
    return chain([*islice(setpoints, 1)], setpoints)


def closed_part(run: Run, robot: str, beat: Exact) -> Iterator[Setpoint]:
    """Return the setpoints of a part that no sense decides, from a beat on. Its robot stands until the part begins."""
    part, begins = run.score.parts[robot], run.score.begins(robot, run.scene)
    movement = part.of_scene(run.scene)
    if beat >= begins:
        return setpoints(part.profile, movement, run.tempo, beat - begins)
    until = float((begins - beat) * 60 / run.tempo)
    standing = takewhile(lambda each: each.at < until, zeros(0.0, 1 / part.profile.command_rate))
    rest = setpoints(part.profile, movement, run.tempo)
    return chain(standing, (each._replace(at=until + each.at) for each in rest))
