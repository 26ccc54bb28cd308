"""Rules by which real robots that were away drive back to their parts. It never reads a clock.

They are slow, and stand while another robot is near or isn't seen. Since parts move on meanwhile, each robot drives to
a place that its part reaches later, and waits there. Lengths are in meters, angles in radians, times in seconds on the
clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import NamedTuple

from improv_core.player.setpoints import Setpoint
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.obstacles import Obstacle
from improv_core.score.profiles import Profile, slow_speeds

HORIZON = 120.0
"""Seconds ahead within which to look for places on a part."""
MOST_CHANGES = 500
"""The most changes of velocity that are looked at: that takes a few milliseconds, and no command may wait longer."""
SAMPLE = 1.0
"""Seconds between two places on a long movement."""
RESERVE, SLACK = 2.0, 1.3
"""Seconds and a factor by which a robot gets more time than its path needs: it has to speed up and to wait."""
GAIN = 1.0
"""The speed of a robot toward a place, for each radian or meter: it slows down before it is there."""
REACHED, AIMED, TURNED = 0.03, math.radians(20), math.radians(2)
"""The distance that is near enough, the error of direction allowed while driving, and that of the heading at the
end."""
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


def places(ideal: Pose, part: Iterable[Setpoint], now: float, end: float) -> Iterator[Rendezvous]:
    """Yield the later poses of a part that is at its `ideal` pose now, until its scene ends. Its setpoints count from
    now."""
    pose, end = ideal, min(end, now + HORIZON)
    changes = [(now + each.at, each.velocity) for each in islice(part, MOST_CHANGES)]
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


def goal(found: Iterable[Rendezvous], pose: Pose, profile: Profile, around: Clearance, now: float) -> Rendezvous | None:
    """Return the first place that a robot can reach in time on a straight path with nothing in it."""
    for place in found:
        needed = SLACK * _seconds(pose, place.pose, profile) + RESERVE
        if now + needed <= place.ends and not _is_blocked(pose, place.pose, profile.radius, around):
            return place
    return None


def toward(pose: Pose, place: Pose, profile: Profile, around: Clearance) -> Twist:
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
