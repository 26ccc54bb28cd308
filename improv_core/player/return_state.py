"""The robots that drive back to their parts, and the velocity that each has now. It never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from improv_core.player.active_parts import closed_part
from improv_core.player.return_rules import ROOM, Clearance, Rendezvous, goal, places, toward
from improv_core.player.run import Run
from improv_core.safety.preflight import Standing, is_there
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.movement import Exact
from improv_core.score.obstacles import obstacles

PERIOD = 0.05
"""Seconds between two commands to a robot that drives back."""
SLIP = 0.25
"""Seconds by which beats may come earlier or later than expected before robots get new goals."""
AGAIN = 1.0
"""Seconds until a robot without a path looks for one again."""


class HomeStep(NamedTuple):
    """The next step of a robot that drives back: a velocity, or None if it plays its part again. `line` is for people,
    unless it is empty."""

    robot: str
    twist: Twist | None
    line: str = ""


@dataclass(frozen=True, slots=True)
class Sightings:
    """Facts at a time on the clock: the beat, the poses of all robots that are seen, the ideal poses of parts, the
    robots whose poses have jumped lately, and the end of this scene."""

    now: float
    beat: Exact
    poses: Mapping[str, Pose]
    ideal: Mapping[str, Pose]
    doubtful: Collection[str]
    ends: float


class Returns:
    """The places at which robots that drive back join their parts again, and their last velocities."""

    def __init__(self) -> None:
        self._goals: dict[str, Rendezvous] = {}
        self._told: dict[str, Twist] = {}
        self._waiting: set[str] = set()  # robots that people know to wait until all are seen
        self._driving: set[str] = set()  # robots that people know to drive back
        self._stuck: dict[str, float] = {}  # when robots without a path look for one again
        self._playing: tuple[object, ...] = ()  # the score and scene of these goals
        self._began = -math.inf
        self._looked = -math.inf

    @property
    def driving(self) -> Collection[str]:
        """The robots on their way back."""
        return self._goals.keys()

    def due(self, run: Run, returning: Collection[str]) -> float:
        """Return the time on the clock at which to look; infinite if no robot is `returning`."""
        if run.mode != "playing" or not (returning or self._told):
            return math.inf
        soonest = min((place.begins for place in self._goals.values() if place.begins > self._looked), default=math.inf)
        return min(self._looked + PERIOD, soonest)

    def look(self, run: Run, back: Collection[str], seen: Sightings) -> list[HomeStep]:
        """Return the next steps of all robots that are `back` and may move."""
        began = seen.now - float(seen.beat * 60 / run.tempo)  # when beat 0 would have been
        if (run.score, run.scene) != self._playing or abs(began - self._began) > SLIP:  # parts will be elsewhere
            self._playing, self._began, self._goals, self._stuck = (run.score, run.scene), began, {}, {}
        self._looked = seen.now
        steps = [*(HomeStep(robot, STILL) for robot in self._told.keys() - back)]
        self._waiting &= {*back}
        self._driving &= {*back}
        for robot in self._goals.keys() - back:
            del self._goals[robot]
        for robot in back:
            steps += self._drive(run, robot, seen)
        for step in steps:
            if step.twist is None or step.robot not in back:
                self._told.pop(step.robot, None)
            else:
                self._told[step.robot] = step.twist
        return steps

    def _drive(self, run: Run, robot: str, seen: Sightings) -> Iterator[HomeStep]:
        told = self._told.get(robot, STILL)
        pose, part = seen.poses.get(robot), run.score.parts[robot]
        if pose is None or robot in seen.doubtful or not run.score.parts.keys() <= seen.poses.keys():
            line = "" if robot in self._waiting else f"{robot} stands until all robots are seen, and then drives back"
            self._waiting.add(robot)
            yield from self._stands(robot, told, line)
            return
        others = {
            other: (where, run.score.parts[other].profile.radius)
            for other, where in seen.poses.items()
            if other != robot and other in run.score.parts
        }
        world = run.score.world
        room = max(world.keep_apart or 0.0, world.margin) + ROOM
        around = Clearance(others, [*obstacles(world)], room, world.margin)
        place, ideal = self._goals.get(robot), seen.ideal.get(robot)
        if ideal and is_there(Standing(ideal, pose), run.score.safety.preflight):
            self._goals.pop(robot, None)
            self._waiting.discard(robot)
            self._driving.discard(robot)
            yield HomeStep(robot, None, f"{robot} is back in its place and continues")
            return
        if not place or seen.now > place.ends:
            place = self._find(run, robot, pose, around, seen)
        if not place:
            line = "" if robot in self._stuck else f"{robot} finds no path to where it should be: carry it there"
            self._stuck[robot] = seen.now + AGAIN
            yield from self._stands(robot, told, line)
            return
        self._goals[robot] = place
        line = "" if robot in self._driving else f"{robot} drives slowly to where it should be, and continues there"
        self._driving.add(robot)
        twist = toward(pose, place.pose, part.profile, around)
        if twist != STILL or told != STILL or line:
            yield HomeStep(robot, twist, line)

    def _find(self, run: Run, robot: str, pose: Pose, around: Clearance, seen: Sightings) -> Rendezvous | None:
        self._goals.pop(robot, None)
        part, ideal = run.score.parts[robot], seen.ideal.get(robot)
        if seen.now < self._stuck.get(robot, -math.inf) or not ideal or part.of_scene(run.scene).open:
            return None
        found = places(ideal, closed_part(run, robot, seen.beat), seen.now, seen.ends)
        return goal(found, pose, part.profile, around, seen.now)

    def _stands(self, robot: str, told: Twist, line: str = "") -> Iterator[HomeStep]:
        if told != STILL or line:
            yield HomeStep(robot, STILL, line)
