"""The scene that plays: which of its parts senses decide, and when each part is over. It never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import chain, takewhile

from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, Duration, Exact, near
from improv_core.score.performer import Decision
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense
from improv_core.stage.open_part import OpenPart, TooManyChangesError
from improv_core.stage.sensing import Sensing
from improv_core.stage.setpoints import Setpoint, setpoints, zeros


class CurrentScene:
    """A scene of a score, whose parts are cast one by one before it plays."""

    def __init__(self, score: Score, sensing: Sensing) -> None:
        self._sensing = sensing
        self._over: dict[str, Duration] = {}  # the beats at which parts are over, if that is known
        self._end: Duration = 0  # the last of them
        self.score = score
        """The score, with the beats at which its parts began."""
        self.index = 0
        """The number of the scene, from 0."""
        self.open: dict[str, OpenPart] = {}
        """The parts that senses decide and that are not over."""
        self.asked: tuple[RobotSense, ...] = ()
        """The senses that these read."""

    def enter(self, score: Score, beat: Exact) -> None:
        """Get ready for the scene that plays at a beat, as if no sense had held before."""
        self.score = score
        self.index, _ = score.scene_at(beat)
        self.open, self._over, self.asked = {}, {}, ()

    def enter_next(self, beat: Exact, poses: Mapping[str, Pose]) -> None:
        """Get ready for the next scene, which begins at a beat. `poses` are where simulated robots are."""
        self.index, self.open, self._over = self.index + 1, {}, {}
        if self.score.open:  # the beat was not known ahead: count from there
            parts = {
                robot: replace(part, begins=beat, scene=self.index, scene_begins=(), entered=poses.get(robot))
                for robot, part in self.score.parts.items()
            }
            self.score = replace(self.score, parts=parts, scene=self.index, since=beat)

    def edit(self, score: Score, robots: Collection[str]) -> None:
        """Another score takes over with its first scene; these robots' parts don't play on."""
        self.score, self.index = score, score.scene
        for robot in robots:
            self.open.pop(robot, None)
            self._over.pop(robot, None)

    def cast(self, robot: str, beat: Exact) -> OpenPart | None:
        """Have a robot play its part from a beat on. Returns the part if senses decide it."""
        movement, begins = self.score.parts[robot].of_scene(self.index), self.begins(robot)
        if not movement.open:
            self._over[robot] = begins + movement.duration
            return None
        if robot not in self.open:
            self.open[robot] = OpenPart(movement, begins, lambda sense: self.value(RobotSense(robot, sense)))
            if begins < beat:
                self.open[robot].skip(beat)
        self._over[robot] = ENDLESS
        self.open[robot].due = max(beat, begins)
        return self.open[robot]

    def begin(self) -> None:
        """All robots have been cast."""
        self._find_end()
        self.asked = tuple(RobotSense(robot, sense) for robot in self.open for sense in self.score.parts[robot].senses)

    def told(self, robot: str, tempo: Fraction, beat: Exact) -> Iterator[Setpoint]:
        """The setpoints of a part that no sense decides, from a beat on. Its robot stands until it begins."""
        part, begins = self.score.parts[robot], self.begins(robot)
        movement = part.of_scene(self.index)
        if beat >= begins:
            return setpoints(part.profile, movement, tempo, beat - begins)
        until = float((begins - beat) * 60 / tempo)
        standing = takewhile(lambda each: each.at < until, zeros(0.0, 1 / part.profile.command_rate))
        return chain(standing, (each._replace(at=until + each.at) for each in setpoints(part.profile, movement, tempo)))

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

    def value(self, what: RobotSense) -> bool | None:
        """What a robot senses now; None if that is not known."""
        part = self.score.parts.get(what.robot)
        return self._sensing.value(what, part.senses if part else {})

    def begins(self, robot: str) -> Exact:
        """The beat at which a robot's part of this scene began."""
        return self.score.begins(robot, self.index)

    @property
    def has_next(self) -> bool:
        """Whether there is another scene."""
        return self.index + 1 < self.score.scenes

    @property
    def ends(self) -> Duration:
        """The beat at which the next scene begins, or all ends."""
        return self._end if isinstance(self._end, float) or not self.has_next else math.ceil(self._end)

    @property
    def beats(self) -> Duration:
        """How long the score lasts, as far as that is known."""
        if not self.score.open:
            return self.score.beats
        return ENDLESS if self.has_next else self._end

    def is_over(self, beat: Exact) -> bool:
        """Whether the whole score is over at a beat."""
        return not self.has_next and not isinstance(self._end, float) and beat >= near(float(self._end))

    def _close(self, robot: str) -> None:
        self._over[robot] = self.open.pop(robot).beat
        self._find_end()

    def _find_end(self) -> None:
        self._end = max(self._over.values(), default=0)
