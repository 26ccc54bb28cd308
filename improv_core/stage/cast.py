"""Who plays what in the scene that plays: which parts senses decide, and when each is over. It never reads a clock."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from itertools import chain, takewhile

from improv_core.score.movement import ENDLESS, Duration, Exact
from improv_core.score.performing import Decision
from improv_core.score.senses import RobotSense
from improv_core.stage.open_part import OpenPart, TooManyChangesError
from improv_core.stage.run import Run
from improv_core.stage.setpoints import Setpoint, setpoints, zeros


class Cast:
    """The parts of a scene. `value` is asked what a robot senses now; None if that is not known."""

    def __init__(self, value: Callable[[RobotSense], bool | None]) -> None:
        self._value = value
        self._over: dict[str, Duration] = {}  # the beats at which parts are over, if that is known
        self.over: Duration = 0
        """The last of them."""
        self.open: dict[str, OpenPart] = {}
        """The parts that senses decide and that are not over."""
        self.asked: tuple[RobotSense, ...] = ()
        """The senses that these read."""

    def dismiss(self, robots: Collection[str] | None = None) -> None:
        """Forget the parts of these robots, or all."""
        if robots is None:
            self.open, self._over, self.asked = {}, {}, ()
            return
        for robot in robots:
            self.open.pop(robot, None)
            self._over.pop(robot, None)

    def begin(self, run: Run, robot: str, beat: Exact) -> OpenPart | None:
        """Have a robot play its part from a beat on. Returns the part if senses decide it."""
        movement, begins = run.score.parts[robot].of_scene(run.scene), run.score.begins(robot, run.scene)
        if not movement.open:
            self._over[robot] = begins + movement.duration
            return None
        if robot not in self.open:
            self.open[robot] = OpenPart(movement, begins, lambda sense: self._value(RobotSense(robot, sense)))
            if begins < beat:
                self.open[robot].skip(beat)
        self._over[robot] = ENDLESS
        self.open[robot].due = max(beat, begins)
        return self.open[robot]

    def complete(self, run: Run) -> None:
        """Note that all robots of the scene have begun."""
        self._find_end()
        self.asked = tuple(RobotSense(robot, sense) for robot in self.open for sense in run.score.parts[robot].senses)

    def perform(self, robot: str, beat: Exact) -> list[Decision]:
        """Perform an open part up to a beat. It is no longer open if it is over.

        Raises TooManyChangesError if it changes too often, and is over by that.
        """
        open_part = self.open[robot]
        try:
            decisions = open_part.perform(beat)
        except TooManyChangesError:
            self._close(robot)
            raise
        if open_part.is_over:
            self._close(robot)
        return decisions

    def _close(self, robot: str) -> None:
        self._over[robot] = self.open.pop(robot).beat
        self._find_end()

    def _find_end(self) -> None:
        self.over = max(self._over.values(), default=0)


def closed_part(run: Run, robot: str, beat: Exact) -> Iterator[Setpoint]:
    """The setpoints of a part that no sense decides, from a beat on. Its robot stands until it begins."""
    part, begins = run.score.parts[robot], run.score.begins(robot, run.scene)
    movement = part.of_scene(run.scene)
    if beat >= begins:
        return setpoints(part.profile, movement, run.tempo, beat - begins)
    until = float((begins - beat) * 60 / run.tempo)
    standing = takewhile(lambda each: each.at < until, zeros(0.0, 1 / part.profile.command_rate))
    rest = setpoints(part.profile, movement, run.tempo)
    return chain(standing, (each._replace(at=until + each.at) for each in rest))
