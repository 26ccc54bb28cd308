"""Computes how far a robot may still come toward a point before it stands, from its measured poses and the velocities
it was sent.

It never reads a clock. Lengths are in meters, angles in radians, times in seconds on the clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.protocol.output import RawPose
from improv_core.safety.odometry import BEYOND, MIN_SPEED
from improv_core.score.following import OLDEST
from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import Profile, slow_speeds

REACTION = 0.1
"""Seconds from the decision to stop a robot until its motors brake: zeros have to arrive, and its base to obey."""
BRAKING = 0.5
"""m/s² with which a robot brakes whose profile has no `max_linear_acceleration`: less than any built-in profile."""
JITTER = 0.03
"""Meters by which the measured distance between two robots that stand may change."""
OLDEST_ELSEWHERE = 0.5
"""Seconds after which a pose that another stage has measured keeps no robot apart: on links, poses are late."""
TURN_LAG = 0.25
"""Seconds by which a robot may turn too late, beyond its reaction: its motors need time."""
POSES_KEPT, POSES_SPAN = 6, 0.5
"""The most poses, and the most seconds, from which a speed is measured."""
EXCESS = 0.1
"""m/s by which a robot's measured speed must exceed the one it was sent so that it counts: poses jitter."""
BESIDE = 1.1
"""Meters beside itself at which a camera may see a robot."""
SENT_KEPT = 1.5
"""Seconds for which a velocity that was sent to a robot counts."""


class Base(NamedTuple):
    """The facts about a robot: its radius, its highest speed in m/s (None: unknown), and its braking in m/s². If a
    stage `elsewhere` moves it, that stage gets poses of the robots here as late as this one gets its poses."""

    radius: float
    max_speed: float | None = None
    braking: float = BRAKING
    elsewhere: bool = False

    @property
    def oldest(self) -> float:
        """The oldest that a pose may be to keep robots apart, in seconds."""
        return OLDEST_ELSEWHERE if self.elsewhere else OLDEST

    @property
    def fastest(self) -> float:
        """The highest speed that counts while it turns, in m/s: if it is seen beside itself, it seems to circle."""
        return BEYOND * self.max_speed if self.max_speed else math.inf


class Approach(NamedTuple):
    """The distance that a robot may come before it stands, if it is sent zero now, and the growth of that distance in
    each second in which it isn't and nothing new is known."""

    far: float
    grows: float


def braking_of(profile: Profile) -> float:
    """Return the deceleration with which a robot brakes, in m/s²."""
    return profile.max_linear_acceleration or BRAKING


def coasting(speed: float, braking: float, age: float) -> float:
    """Return the most meters that a robot at this speed, in m/s, may be beyond its latest pose when it stands, if it
    gets the command now and that pose is this many seconds old."""
    return speed * (age + REACTION) + speed * speed / 2 / braking


def slow_coasting(profile: Profile) -> float:
    """Return the meters that a robot on its slow way to a place may still come after the oldest pose that counts."""
    return coasting(slow_speeds(profile)[0], braking_of(profile), OLDEST)


class _Velocity(NamedTuple):
    """A velocity: in m/s in a direction on the floor, upward, and in total; and the turn in rad/s. The direction is in
    the robot's own frame if the robot was sent the velocity, and in the world if it was measured."""

    speed: float
    direction: float
    up: float
    size: float
    yaw: float

    @classmethod
    def of(cls, x: float, y: float, z: float, yaw: float) -> _Velocity:
        return cls(math.hypot(x, y), math.atan2(y, x), z, math.hypot(x, y, z), yaw)


class _Sent(NamedTuple):
    """A velocity that a robot was sent at a time, and the angle by which it had been sent to turn by then."""

    at: float
    twist: Twist
    velocity: _Velocity
    turned: float

    def turned_by(self, at: float) -> float:
        return self.turned + self.twist.yaw * max(at - self.at, 0.0)


@dataclass(frozen=True, slots=True)
class Track:
    """The latest poses of a robot, one that doesn't count yet because the robot can't have moved there, and the
    velocities it was sent lately."""

    poses: tuple[RawPose, ...] = ()
    doubted: RawPose | None = None
    sent: tuple[_Sent, ...] = ()

    @property
    def heard_at(self) -> float:
        """The time of the latest pose, even if it doesn't count."""
        last = self.doubted or (self.poses[-1] if self.poses else None)
        return last.at if last else -math.inf

    @property
    def top_speed(self) -> float:
        """The highest speed in m/s that the robot was sent lately, or that was measured."""
        return max([*(each.velocity.size for each in self.sent), *(seen.size for seen in self._seen())], default=0.0)

    def heard(self, raw: RawPose, max_speed: float | None) -> Track:
        """Return the track after a pose. If the robot can't have moved there, it counts once the next one agrees."""
        track = self if raw.told is None else self.after(raw.told, raw.at)
        fastest = BEYOND * max_speed if max_speed else max(MIN_SPEED, BEYOND * track.top_speed)
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
        """Return the track after the robot was sent this velocity."""
        turned = 0.0
        if self.sent:
            last = self.sent[-1]
            if twist == last.twist:
                return self
            at = max(at, last.at)
            turned = last.turned_by(at)
        ended = next((number for number, each in enumerate(self.sent[1:]) if each.at >= at - SENT_KEPT), 0)
        sent = _Sent(at, twist, _Velocity.of(twist.x, twist.y, twist.z, twist.yaw), turned)
        return replace(self, sent=(*self.sent[ended:], sent))

    def most(self, base: Base, ages: Sequence[float]) -> list[Approach]:
        """Return the most that `reach` may be in any direction, for each of these ages of the latest pose."""
        speed, times = self.top_speed, 2 if base.elsewhere else 1
        before, last = self.poses[-2:][0], self.poses[-1]
        further, moved = last.at - before.at, last.pose.apart(before.pose)[0]
        return [Approach(coasting(speed, base.braking, times * age + further) + moved, times * speed) for age in ages]

    def reach(self, base: Base, point: Pose, now: float) -> Approach:
        """Return how far it may come toward a point from either of its latest two poses: one may be wrong."""
        last = self.poses[-1]
        age, way = (2 if base.elsewhere else 1) * max(now - last.at, 0.0), _Way.between(last.pose, point)
        found = []
        for raw in self.poses[-2:]:
            moved = raw.pose.x - last.pose.x, raw.pose.y - last.pose.y, raw.pose.z - last.pose.z
            by = self._reach_from(raw, age + last.at - raw.at, way, base, now)
            found.append(by._replace(far=by.far + way.speed(_Velocity.of(*moved, 0.0), 0.0, 0.0)))
        return max(found)

    def _reach_from(self, raw: RawPose, age: float, way: _Way, base: Base, now: float) -> Approach:
        """Return how far it may come in a direction from a pose of this age.

        From a reaction before that until now, it may have moved as it was sent, and it continues for a reaction. If it
        has moved in that direction faster than it was sent, it continues at that speed. Then it brakes.
        """
        times = 2 if base.elsewhere else 1
        begin = now - age - REACTION
        headed = [self._turned_by(at) for at in (begin - TURN_LAG, raw.at)]
        least, most = min(headed), max(headed)
        speed, slowing = 0.0, base.braking  # toward the point, and its braking in that direction
        far = wanted = fastest = 0.0
        for number, (at, _, velocity, turned) in enumerate(self.sent, 1):
            is_last = number == len(self.sent)
            end = now if is_last else min(self.sent[number].at, now)
            # It may obey the last velocity until it stands.
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
        sent = Approach(far + speed * speed / 2 / slowing, times * wanted)
        measured = [(_measured_along(way, each, base.braking), each.size) for each in self._seen(base.fastest)]
        seen, size = min(measured, default=(0.0, 0.0))
        if seen <= fastest + EXCESS:
            return sent
        return max(sent, Approach(seen / size * coasting(size, base.braking, age), times * seen))

    def _seen(self, fastest: float = math.inf) -> list[_Velocity]:
        """Return its speed by two pairs of poses, so that one imprecise pose makes no robot fast; empty if unknown."""
        if len(self.poses) < 4:
            return []
        pairs = (self.poses[0], self.poses[-1]), (self.poses[1], self.poses[-2])
        return [_measured(one, other, fastest) for one, other in pairs]

    def _turned_by(self, at: float) -> float:
        """Return the angle by which it had been sent to turn by a time."""
        first = self.sent[0].turned if self.sent else 0.0
        return next((each.turned_by(at) for each in reversed(self.sent) if each.at <= at), first)


class _Way(NamedTuple):
    """A direction in the world: that on the floor, and its level and its vertical share."""

    direction: float
    level: float
    steep: float

    @classmethod
    def between(cls, pose: Pose, point: Pose) -> _Way:
        x, y, z = point.x - pose.x, point.y - pose.y, point.z - pose.z
        far = math.hypot(x, y, z)
        return cls(math.atan2(y, x), math.hypot(x, y) / far, z / far) if far else cls(0.0, 0.0, 0.0)

    def speed(self, velocity: _Velocity, heading: float, turn: float) -> float:
        """Return the highest speed at which a velocity in a robot's frame goes in this direction, while that frame
        turns from a heading."""
        ahead = (self.direction - velocity.direction - heading) % math.tau
        cos = 1.0 if ahead <= turn else max(math.cos(ahead), math.cos(ahead - turn))
        return velocity.speed * self.level * cos + velocity.up * self.steep


def _moved(speed: float, wanted: float, braking: float, seconds: float) -> tuple[float, float]:
    """Return the speed of a robot after some seconds in which it was sent another one, and the distance it has come. It
    may speed up at once, and slows down by braking."""
    if wanted >= speed:
        return wanted, wanted * seconds
    brakes = min(seconds, (speed - wanted) / braking)
    then = max(speed - braking * brakes, wanted)
    return then, (speed + then) / 2 * brakes + wanted * (seconds - brakes)


def _measured(one: RawPose, other: RawPose, fastest: float) -> _Velocity:
    seconds, from_, to = other.at - one.at, one.pose, other.pose
    turn = math.remainder(to.heading - from_.heading, math.tau)
    x, y, z = to.x - from_.x, to.y - from_.y, to.z - from_.z
    moved = math.hypot(x, y, z)
    longer = max(moved / fastest if moved <= BESIDE * abs(turn) else 0.0, seconds)
    return _Velocity.of(x / longer, y / longer, z / longer, turn / seconds)


def _measured_along(way: _Way, seen: _Velocity, braking: float) -> float:
    """Return the highest speed at which a robot with this measured velocity may go in a direction until it stands."""
    turn = seen.yaw * (OLDEST + REACTION + seen.size / braking)
    return way.speed(seen, min(turn, 0.0), abs(turn))


def _agrees(raw: RawPose, last: RawPose, fastest: float) -> bool:
    """Return whether a robot can have moved from one pose to another."""
    return raw.pose.apart(last.pose)[0] <= JITTER + fastest * abs(raw.at - last.at)
