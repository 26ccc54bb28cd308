"""How far a robot may still come toward a point before it stands, by its measured poses and what it was told. It never
reads a clock.

Lengths are in meters, angles in radians, times in seconds on the clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.protocol.output import RawPose
from improv_core.safety.odometry import BEYOND, LEAST_SPEED
from improv_core.score.braking import BRAKING, REACTION, coasting
from improv_core.score.following import OLDEST
from improv_core.score.motion import Pose, Twist

JITTER = 0.03
"""Meters by which the distance of two robots that stand may seem to change."""
OLDEST_ELSEWHERE = 0.5
"""Seconds after which a pose that another stage has measured keeps nobody apart: on links, poses are late."""
TURN_LAG = 0.25
"""Seconds by which a robot may turn later than it was told, beyond its reaction: its motors need time."""
POSES_KEPT, POSES_SPAN = 6, 0.5
"""From how many poses a speed is measured at most, and from how many seconds."""
UNTOLD = 0.1
"""m/s by which a robot must seem to be faster than it was told so that this counts: poses jitter."""
TOLD_KEPT = 1.5
"""Seconds for which it counts what a robot was told."""


class Base(NamedTuple):
    """What is known about a robot: its radius, its highest speed in m/s (None: unknown), and how hard it brakes in
    m/s². A stage `elsewhere` that moves it knows as late about the robots here as the one here knows about it."""

    radius: float
    max_speed: float | None = None
    braking: float = BRAKING
    elsewhere: bool = False

    @property
    def oldest(self) -> float:
        """How old a pose may be so that it keeps robots apart, in seconds."""
        return OLDEST_ELSEWHERE if self.elsewhere else OLDEST


class Approach(NamedTuple):
    """How far a robot may come until it stands, if it is told so now, and by how much that grows in each second in
    which it isn't, and nothing new is known."""

    far: float
    grows: float


class _Velocity(NamedTuple):
    """A velocity: in m/s in a direction on the floor, upward, and in all; and how fast it turns. The direction is that
    in the robot's own frame for what it was told, and that in the world for what was measured."""

    speed: float
    direction: float
    up: float
    size: float
    yaw: float

    @classmethod
    def of(cls, x: float, y: float, z: float, yaw: float) -> _Velocity:
        return cls(math.hypot(x, y), math.atan2(y, x), z, math.hypot(x, y, z), yaw)


class _Told(NamedTuple):
    """What a robot was told at a time, and how far it had been told to turn by then."""

    at: float
    twist: Twist
    velocity: _Velocity
    turned: float

    def turned_by(self, at: float) -> float:
        return self.turned + self.twist.yaw * max(at - self.at, 0.0)


@dataclass(frozen=True, slots=True)
class Track:
    """The latest poses of a robot, one to which it can't have moved so that it doesn't count yet, and what it was told
    lately."""

    poses: tuple[RawPose, ...] = ()
    doubted: RawPose | None = None
    told: tuple[_Told, ...] = ()

    @property
    def heard_at(self) -> float:
        """When the latest pose was measured, whether or not it counts."""
        last = self.doubted or (self.poses[-1] if self.poses else None)
        return last.at if last else -math.inf

    @property
    def top_speed(self) -> float:
        """The highest speed in m/s that it was told, or that was measured, lately."""
        return max([*(each.velocity.size for each in self.told), *(seen.size for seen in self._seen())], default=0.0)

    def heard(self, raw: RawPose, max_speed: float | None) -> Track:
        """After a pose. If the robot can't have moved there, it counts once the next one agrees."""
        track = self if raw.told is None else self.after(raw.told, raw.at)
        fastest = BEYOND * max_speed if max_speed else max(LEAST_SPEED, BEYOND * track.top_speed)
        last = track.poses[-1] if track.poses else None
        if last is None or abs(raw.at - last.at) > OLDEST:
            return replace(track, poses=(raw,), doubted=None)
        if _agrees(raw, last, fastest):
            recent = [each for each in track.poses if raw.at - POSES_SPAN <= each.at < raw.at]
            return replace(track, poses=(*recent[1 - POSES_KEPT :], raw), doubted=None)
        if track.doubted and _agrees(raw, track.doubted, fastest):
            return replace(track, poses=(raw,), doubted=None)
        return replace(track, doubted=raw)

    def after(self, twist: Twist, at: float) -> Track:
        """After the robot was told to move like this."""
        turned = 0.0
        if self.told:
            last = self.told[-1]
            if twist == last.twist:
                return self
            at = max(at, last.at)
            turned = last.turned_by(at)
        ended = next((number for number, each in enumerate(self.told[1:]) if each.at >= at - TOLD_KEPT), 0)
        told = _Told(at, twist, _Velocity.of(twist.x, twist.y, twist.z, twist.yaw), turned)
        return replace(self, told=(*self.told[ended:], told))

    def most(self, base: Base, ages: Sequence[float]) -> list[Approach]:
        """The most that `reach` may be in any direction once the latest pose is so old, for each of these ages."""
        speed, times = self.top_speed, 2 if base.elsewhere else 1
        return [Approach(coasting(speed, base.braking, times * age), times * speed) for age in ages]

    def reach(self, base: Base, point: Pose, now: float) -> Approach:
        """How far it may come toward a point.

        Since its latest pose, and a reaction before that, it may have moved as it was told, and it goes on for a
        reaction. If it has moved toward the point faster than it was told, it goes on like that. Then it brakes.
        """
        raw = self.poses[-1]
        age, times = max(now - raw.at, 0.0), 2 if base.elsewhere else 1
        begin, way = now - times * age - REACTION, _Way.between(raw.pose, point)
        headed = [self._turned_by(at) for at in (begin - TURN_LAG, raw.at)]
        least, most = min(headed), max(headed)
        speed, slowing = 0.0, base.braking  # toward the point, and how hard it brakes in that direction
        far = wanted = fastest = 0.0
        for number, (at, _, velocity, turned) in enumerate(self.told, 1):
            is_last = number == len(self.told)
            end = now if is_last else min(self.told[number].at, now)
            # What it was told last, it may do until it stands.
            lasts = end - at + (REACTION + velocity.size / base.braking if is_last else 0.0)
            turn = velocity.yaw * lasts
            low, high = turned + min(turn, 0.0) - most, turned + max(turn, 0.0) - least
            wanted = max(way.speed(velocity, raw.pose.heading + low, high - low), 0.0)
            split = min(max(begin, at), end)
            speed, _ = _moved(speed, wanted, slowing, split - at)
            speed, moved = _moved(speed, wanted, slowing, end - split)
            far += moved
            if 0 < speed <= wanted:
                slowing = base.braking * wanted / velocity.size
            if end >= self.poses[0].at - REACTION:
                fastest = max(fastest, wanted)
        told = Approach(far + speed * speed / 2 / slowing, times * wanted)
        measured = [(_measured_along(way, each, base.braking), each.size) for each in self._seen()]
        seen, size = min(measured, default=(0.0, 0.0))
        if seen <= fastest + UNTOLD:
            return told
        return max(told, Approach(seen / size * coasting(size, base.braking, times * age), times * seen))

    def _seen(self) -> list[_Velocity]:
        """How fast it moves by two pairs of poses, so that one that is a bit off makes no robot fast; none if it isn't
        known."""
        if len(self.poses) < 4:
            return []
        return [_measured(self.poses[0], self.poses[-1]), _measured(self.poses[1], self.poses[-2])]

    def _turned_by(self, at: float) -> float:
        """How far it had been told to turn by a time."""
        first = self.told[0].turned if self.told else 0.0
        return next((each.turned_by(at) for each in reversed(self.told) if each.at <= at), first)


class _Way(NamedTuple):
    """A direction in the world: that on the floor, and how level and how steep it is."""

    direction: float
    level: float
    steep: float

    @classmethod
    def between(cls, pose: Pose, point: Pose) -> _Way:
        x, y, z = point.x - pose.x, point.y - pose.y, point.z - pose.z
        far = math.hypot(x, y, z)
        return cls(math.atan2(y, x), math.hypot(x, y) / far, z / far) if far else cls(0.0, 0.0, 0.0)

    def speed(self, velocity: _Velocity, heading: float, turn: float) -> float:
        """How fast a velocity in the frame of a robot goes this way at most, while that turns from a heading."""
        ahead = (self.direction - velocity.direction - heading) % math.tau
        cos = 1.0 if ahead <= turn else max(math.cos(ahead), math.cos(ahead - turn))
        return velocity.speed * self.level * cos + velocity.up * self.steep


def _moved(speed: float, wanted: float, braking: float, seconds: float) -> tuple[float, float]:
    """The speed of a robot that is told to move at another one, after some seconds, and how far it has come. It may
    speed up at once, and brakes."""
    if wanted >= speed:
        return wanted, wanted * seconds
    brakes = min(seconds, (speed - wanted) / braking)
    then = max(speed - braking * brakes, wanted)
    return then, (speed + then) / 2 * brakes + wanted * (seconds - brakes)


def _measured(one: RawPose, other: RawPose) -> _Velocity:
    seconds, from_, to = other.at - one.at, one.pose, other.pose
    turn = math.remainder(to.heading - from_.heading, math.tau)
    moved = to.x - from_.x, to.y - from_.y, to.z - from_.z, turn
    return _Velocity.of(*(each / seconds for each in moved))


def _measured_along(way: _Way, seen: _Velocity, braking: float) -> float:
    """How fast a robot that was seen to move may go a way until it stands."""
    turn = seen.yaw * (OLDEST + REACTION + seen.size / braking)
    return way.speed(seen, min(turn, 0.0), abs(turn))


def _agrees(raw: RawPose, last: RawPose, fastest: float) -> bool:
    """Whether a robot can have moved from one pose to another."""
    return raw.pose.apart(last.pose)[0] <= JITTER + fastest * abs(raw.at - last.at)
