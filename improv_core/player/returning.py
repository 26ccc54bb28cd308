"""Real robots that were away and drive back to their parts, and the velocity that each has now. It never reads a clock.

They are slow, and stand while another robot is near or isn't seen. Since parts move on meanwhile, each robot drives to
a place that its part reaches later, and waits there. Lengths are in meters, angles in radians, times in seconds on the
clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import NamedTuple

from improv_core.player.active_parts import closed_part
from improv_core.player.run import Run
from improv_core.player.setpoint_queue import Setpoint
from improv_core.safety.preflight import Standing, is_there
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.movement import Exact
from improv_core.score.obstacles import Obstacle, obstacles
from improv_core.score.profiles import Profile, slow_speeds

PERIOD = 0.05
"""Seconds between two commands to a robot that drives back."""
SLIP = 0.25
"""Seconds by which beats may come earlier or later than expected before robots get new goals."""
AGAIN = 1.0
"""Seconds until a robot without a path looks for one again."""
HORIZON = 120.0
"""Seconds ahead within which to look for places on a part."""
MAX_CHANGES = 500
"""The most changes of velocity that are looked at: that takes a few milliseconds, and no command may wait longer."""
SAMPLE = 1.0
"""Seconds between two places on a long movement."""
RESERVE, SLACK = 2.0, 1.3
"""Seconds and a factor by which a robot gets more time than its path needs: it has to speed up and to wait."""
GAIN = 1.0
"""The speed of a robot toward a place, for each radian or meter: it slows down before it is there."""
REACHED, AIMED, TURNED = 0.03, math.radians(20), math.radians(2)
"""The distance that is near enough, and the errors of the direction while driving, and of the heading at the end."""
AHEAD = 1.0
"""Seconds after which a robot must not be too near to another one."""
ROOM = 0.2
"""Meters that it keeps from other robots beyond the usual distance: they are faster."""


class Rendezvous(NamedTuple):
    """A pose at which a part has its robot from one time to another, without moving it in between."""

    pose: Pose
    begins: float
    ends: float


@dataclass(frozen=True, slots=True)
class Clearance:
    """Obstacles that a robot avoids: the poses of `others`, with their radii, and `things` in the world. It keeps
    `room` from robots and `margin` from things."""

    others: Mapping[str, tuple[Pose, float]]
    things: Sequence[Obstacle]
    room: float
    margin: float


class HomeStep(NamedTuple):
    """The next step of a robot that drives back: a velocity, or None if it plays again. `line` is for people."""

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
        twist = _toward(pose, place.pose, part.profile, around)
        if twist != STILL or told != STILL or line:
            yield HomeStep(robot, twist, line)

    def _find(self, run: Run, robot: str, pose: Pose, around: Clearance, seen: Sightings) -> Rendezvous | None:
        self._goals.pop(robot, None)
        part, ideal = run.score.parts[robot], seen.ideal.get(robot)
        if seen.now < self._stuck.get(robot, -math.inf) or not ideal or part.of_scene(run.scene).open:
            return None
        found = _places(ideal, closed_part(run, robot, seen.beat), seen.now, seen.ends)
        return _goal(found, pose, part.profile, around, seen.now)

    def _stands(self, robot: str, told: Twist, line: str = "") -> Iterator[HomeStep]:
        if told != STILL or line:
            yield HomeStep(robot, STILL, line)


def _places(ideal: Pose, part: Iterable[Setpoint], now: float, end: float) -> Iterator[Rendezvous]:
    """Yield a part's poses from its `ideal` one now until its scene ends. Its setpoints count from now."""
    pose, end = ideal, min(end, now + HORIZON)
    changes = [(now + each.at, each.velocity) for each in islice(part, MAX_CHANGES)]
    last = changes[-1:]
    for (at, twist), (until, _) in pairwise([*changes, *((max(at, end), twist) for at, twist in last)]):
        until = min(until, end)
        if at >= end or not isinstance(twist, Twist):
            return
        if twist == STILL:
            yield Rendezvous(pose, at, until)
            continue
        for number in range(max(math.ceil((until - at) / SAMPLE), 1)):
            passed = number * SAMPLE
            yield Rendezvous(pose.after(twist, passed), at + passed, at + passed)
        pose = pose.after(twist, until - at)


def _goal(
    found: Iterable[Rendezvous], pose: Pose, profile: Profile, around: Clearance, now: float
) -> Rendezvous | None:
    """Return the first place that a robot can reach in time on a straight path with nothing in it."""
    for place in found:
        needed = SLACK * _seconds(pose, place.pose, profile) + RESERVE
        if now + needed <= place.ends and not _is_blocked(pose, place.pose, profile.radius, around):
            return place
    return None


def _toward(pose: Pose, place: Pose, profile: Profile, around: Clearance) -> Twist:
    """Return the velocity of a robot on its way to a place: it turns toward it, drives there, and turns to the heading.
    It stands while another robot is in its way."""
    linear, angular = slow_speeds(profile)
    off = pose.inverse().then(place)
    far, aim = math.hypot(off.x, off.y), math.atan2(off.y, off.x)
    if far <= REACHED:
        turn = math.remainder(off.heading, math.tau)
        return Twist(yaw=_clamped(GAIN * turn, angular)) if abs(turn) > TURNED else STILL
    turning = _clamped(GAIN * aim, angular)
    if abs(aim) > AIMED:
        return Twist(yaw=turning)
    twist = Twist(min(GAIN * far, linear), yaw=turning)
    return STILL if _comes_near(pose, pose.after(twist, AHEAD), profile.radius, around) else twist


def _seconds(pose: Pose, place: Pose, profile: Profile) -> float:
    """Return the seconds that a robot needs to reach a place."""
    linear, angular = slow_speeds(profile)
    x, y = place.x - pose.x, place.y - pose.y
    far = math.hypot(x, y)
    first = math.atan2(y, x) if far > REACHED else pose.heading
    turns = abs(math.remainder(first - pose.heading, math.tau)) + abs(math.remainder(place.heading - first, math.tau))
    return far / linear + turns / angular


def _is_blocked(pose: Pose, place: Pose, radius: float, around: Clearance) -> bool:
    """Return whether something in the world blocks a straight path. A robot too near to it may drive away."""
    count = max(math.ceil(math.dist((pose.x, pose.y), (place.x, place.y)) / max(radius, REACHED)), 1)
    way = [(number / count, 1 - number / count) for number in range(count + 1)]
    points = [(pose.x * rest + place.x * share, pose.y * rest + place.y * share) for share, rest in way]
    for thing in around.things:
        enough = min(radius + around.margin, thing.distance(pose.x, pose.y)[0])
        if any(thing.distance(*point)[0] < enough for point in points):
            return True
    return False


def _comes_near(pose: Pose, then: Pose, radius: float, around: Clearance) -> bool:
    for other, wide in around.others.values():
        enough, after = radius + wide + around.room, then.apart(other)[0]
        if after < enough and after < pose.apart(other)[0]:
            return True
    return False


def _clamped(value: float, most: float) -> float:
    return max(-most, min(most, value))
