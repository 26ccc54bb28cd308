"""The measured poses of robots, compared with their poses in the score. It never reads a clock.

All times are the clock's, in seconds. Standard library only.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from improv_core.protocol.messages import SIMULATED
from improv_core.protocol.output import RawPose
from improv_core.safety.preflight import Standing
from improv_core.score.dynamics import motors_of
from improv_core.score.following import OLDEST, RESTS, accelerated, before_stopping, correction, learned
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import DEFAULT, Profile, beside_robots
from improv_core.score.score import Part

LEGS_KEPT = 1000
"""The number of changes of velocity that are remembered until a later pose arrives."""
JUMP, JUMP_TURN = 0.1, 0.3
"""Meters and radians that count as a jump, beyond the distance that the robot's fastest velocity explains."""
MIN_SPEED, MIN_TURN = 1.0, 3.0
"""m/s and rad/s: if a robot's limits are unknown, this is never a jump, since somebody else may drive it."""
BEYOND = 1.5
"""The factor by which a robot may exceed its limits: wheels roll farther than they should, and slopes help."""
UNEVEN = 0.1
"""Seconds by which the time between two poses may seem too short, because the first of them came late."""
LAGS = (0.08, 0.16, 0.25)
"""Seconds by which a robot may be behind: its poses come late, and its motors need time. At 0.9 m/s² and 7.7 rad/s², a
TurtleBot3 that starts at its limits lags by 0.12 s and 0.18 s, and poses came 80 ms late."""
AHEAD, BEHIND = -0.05, 1.0
"""The least and the most seconds from a stamp to the arrival of its pose: outside of them, the clocks don't agree."""
DOUBTFUL = 10.0
"""Seconds after a jump in which poses in the world correct nothing: they may be those of another robot."""
FRESH = 1.0
"""Seconds for which a pose still shows where a robot stands without commands."""
AFTER_MOVING = "geometry_msgs/PoseWithCovarianceStamped"
"""The source that sends a pose only after a robot has moved: localization on a map, such as AMCL."""
FROM_ELSEWHERE = "another stage"
"""The source of poses of robots that stages elsewhere move."""
CONTINUOUS = "nav_msgs/Odometry"
"""The source whose frame never jumps (REP 105), unless it has started over. Others may correct themselves."""


class Comparison(NamedTuple):
    """A robot's measured pose at a time, and its ideal pose then, both in the world of the score.

    `aligned` counts how often its frame was aligned with that world in this performance. Each time, its path begins
    again. `follows` is true if corrections pull it back to its ideal path. `recent` are its ideal poses a moment
    before, one for each of the `LAGS`. `jump` is the distance between this pose and the one before, in meters and
    radians, if the robot can't have moved so far.
    """

    raw: RawPose
    pose: Pose
    ideal: Pose
    aligned: int
    follows: bool
    recent: tuple[Pose, ...] = ()
    jump: tuple[float, float] | None = None


class Odometry:
    """Aligns the frames of measured poses with the world of the score, and computes the ideal poses of robots.

    Ideally, a robot obeys every velocity at once and exactly. A robot's own frame is aligned at beat 0 and after a
    seek, so that the robot is at its pose in the score. Poses in the world of the score are taken as they are.
    """

    def __init__(self) -> None:
        self._tracks: dict[str, _Track] = {}
        self._elsewhere: dict[str, str] = {}  # the frames of robots that other stages move
        self.frames: dict[str, str] = {}
        """The frames of poses in the world, by robot."""
        self.strays: frozenset[str] = frozenset()
        """The robots whose poses in the world don't count, because those of others have another frame."""

    def begin(self, parts: Mapping[str, Part], at: float) -> None:
        """Begin a performance with its robots at their starts."""
        latest = {robot: track.latest for robot, track in self._tracks.items()}
        self._tracks = {}
        self.set_parts(parts, at)
        for robot, track in self._tracks.items():
            track.latest = latest.get(robot)

    def set_parts(self, parts: Mapping[str, Part], at: float) -> None:
        """Use the parts of another score. New robots begin at their starts, and a robot that takes over the part of
        another one begins at that one's ideal pose."""
        for robot in self._tracks.keys() - parts.keys():
            del self._tracks[robot]
        there = {robot for robot, part in parts.items() if part.elsewhere}
        self._elsewhere = {robot: frame for robot, frame in self._elsewhere.items() if robot in there}
        for robot, part in parts.items():
            if part.elsewhere or (not part.odom and part.profile.dynamics == "ideal"):
                self._tracks.pop(robot, None)
            else:
                if robot not in self._tracks:
                    self._tracks[robot] = _Track(at, part.entered or part.start)
                track = self._tracks[robot]
                if track.topic not in ("", part.topic):
                    track.place(track.legs[-1].pose_at(at), at)
                    track.latest = None  # another robot has been elsewhere, so the next pose is no jump
                track.set_part(part)
        self._compare_frames()

    def place(self, poses: Mapping[str, Pose], at: float) -> None:
        for robot, pose in poses.items():
            if track := self._tracks.get(robot):
                track.place(pose, at)

    def tell(self, robot: str, twist: Twist, at: float) -> None:
        if track := self._tracks.get(robot):
            track.tell(twist, at)

    def correction(self, robot: str, twist: Twist, at: float) -> Twist:
        """Return the twist to add to a velocity that is sent to a robot at this time, if it follows its ideal path."""
        track = self._tracks.get(robot)
        return track.correction(twist, at) if track and robot not in self.strays else STILL

    def corrected(self, robot: str, twist: Twist, at: float) -> Twist:
        """Return the velocity to send to a robot at this time: `twist` plus its correction."""
        correction = STILL if twist == STILL else self.correction(robot, twist, at)
        return twist if correction == STILL else twist.plus(correction)

    def is_doubtful(self, robot: str, at: float) -> bool:
        """Return whether the poses of a robot have jumped lately, so that they may be those of another robot."""
        track = self._tracks.get(robot)
        return track is not None and at < track.jumped + DOUBTFUL

    def taken_at(self, raw: RawPose) -> float:
        """Return the time at which a pose was measured: its stamp if the clocks seem to agree, or its arrival."""
        track = self._tracks.get(raw.robot)
        return track.taken_at(raw) if track else raw.at

    def ages(self) -> dict[str, float]:
        """Return the least age in seconds of each robot's poses on arrival, if some have come since the last call."""
        found = {robot: track.youngest for robot, track in self._tracks.items() if track.youngest < math.inf}
        for robot in found:
            self._tracks[robot].youngest = math.inf
        return found

    def clocks(self) -> dict[str, float]:
        """Return by how many seconds the clock that stamps a robot's poses is ahead of ours, at least, for each robot
        whose clock doesn't agree. A number below 0 means that it is behind, by that much at most."""
        known = {robot: track.least for robot, track in self._tracks.items() if track.least < math.inf}
        return {robot: -least for robot, least in known.items() if not AHEAD <= least <= BEHIND}

    def fits(self, raw: RawPose) -> bool:
        """Return whether a pose is of the robot with this part now: another's may still have been on its way."""
        track = self._tracks.get(raw.robot)
        return not (track and raw.topic) or raw.topic == track.odom

    def lacks(self, robots: Iterable[str]) -> bool:
        """Return whether no pose of one of these robots has been taken, although it is compared."""
        return any(robot in self._tracks and not self._tracks[robot].latest for robot in robots)

    def take(self, raw: RawPose) -> Comparison | None:
        """Take a pose and compare it with the ideal one. Returns None if it can't be compared."""
        track = self._tracks.get(raw.robot)
        found = track.take(raw, raw.robot not in self.strays) if track else None
        if raw.source == FROM_ELSEWHERE:
            self._elsewhere[raw.robot] = _frame(raw)
        elif not (track and track.in_world):
            return found
        if self.frames.get(raw.robot) != _frame(raw):
            self._compare_frames()
        return found

    def places(self, now: float) -> dict[str, Standing]:
        """Return the ideal and the measured places at a time of the robots whose poses are in the world."""
        places = {robot: track.place_at(now) for robot, track in self._tracks.items() if track.in_world}
        if not self.strays:
            return places
        why = "its poses are in the frame {!r}, unlike those of others: publish all in one frame"
        where = {robot: self.frames[robot] for robot in self.strays & places.keys()}
        return places | {robot: Standing(places[robot].ideal, None, why.format(where[robot])) for robot in where}

    @property
    def robots(self) -> Collection[str]:
        return self._tracks.keys()

    def _compare_frames(self) -> None:
        latest = {robot: track.latest for robot, track in self._tracks.items() if track.in_world}
        here = {robot: _frame(raw) for robot, raw in latest.items() if raw and raw.source != SIMULATED}
        self.frames = {**self._elsewhere, **here}
        self.strays = strays(self.frames)


def strays(frames: Mapping[str, str]) -> frozenset[str]:
    """Return the robots that don't name the frame of the majority: their poses can't be compared with the others'."""
    usual = next((frame for frame, count in Counter(frames.values()).items() if 2 * count > len(frames)), None)
    return frozenset(robot for robot, frame in frames.items() if frame != usual)


def _frame(raw: RawPose) -> str:
    """Return the frame of a pose. A slash before it was allowed in ROS 1."""
    return raw.frame.removeprefix("/")


class _Leg(NamedTuple):
    """A robot's ideal pose at a time, its ideal velocity from then on, and its motors' speed then."""

    at: float
    pose: Pose
    twist: Twist
    speed: Twist = STILL

    def pose_at(self, at: float) -> Pose:
        return self.pose.after(self.twist, at - self.at).above_ground()


@dataclass(slots=True)
class _Track:
    """One robot: its ideal path since the latest pose, and the pose of its frame in the world (None: unknown).

    A robot that is `in_world` has no frame of its own, so it may begin elsewhere than in the score. If it follows its
    ideal path, `limits` are its own, and `error` has its ideal pose, its measured pose, and the time of both. Its turns
    end `late` by this many seconds, and `ended` is the time and the speed of one that has just ended.
    """

    since: float
    start: Pose
    legs: deque[_Leg] = field(init=False)
    topic: str = ""
    odom: str | None = None
    frame: Pose | None = None
    in_world: bool = False
    aligned: int = 1
    latest: RawPose | None = None
    fastest: float = MIN_SPEED
    fastest_turn: float = MIN_TURN
    profile: Profile = DEFAULT
    accelerations: tuple[float, float] = (math.inf, math.inf)
    limits: tuple[float, float] | None = None
    error: tuple[Pose, Pose, float] | None = None
    late: float = 0.0
    ended: tuple[float, float] | None = None
    least: float = math.inf  # seconds from a stamp to its arrival
    youngest: float = math.inf  # the least age of a pose on arrival, lately
    jumped: float = -math.inf  # the time of the latest jump of its poses in the world

    def __post_init__(self) -> None:
        self.legs = deque([_Leg(self.since, self.start, STILL)], LEGS_KEPT)

    def set_part(self, part: Part) -> None:
        if (part.topic, part.profile) != (self.topic, self.profile):
            self.late, self.ended = 0.0, None
        self.topic, self.odom = part.topic, part.odom
        self.profile = profile = part.profile
        motors = motors_of(beside_robots(profile), part.robot)
        self.accelerations = (motors.linear_acceleration, motors.angular_acceleration) if motors else (math.inf,) * 2
        linear, angular = profile.max_linear, profile.max_angular
        self.limits = (linear, angular) if part.follow and linear and angular else None
        if (in_world := part.odom_frame == "world") != self.in_world:
            self.in_world, self.frame, self.aligned = in_world, None, self.aligned + 1

    def place(self, pose: Pose, at: float) -> None:
        self.since, self.frame, self.aligned, self.error, self.ended = at, None, self.aligned + 1, None, None
        self.legs = deque([_Leg(at, pose, STILL)], LEGS_KEPT)

    def tell(self, twist: Twist, at: float) -> None:
        last = self.legs[-1]
        if twist == last.twist:
            return
        at, speed = max(at, last.at), self._speed(last, at)
        self.legs.append(_Leg(at, last.pose_at(at), twist, speed))
        self.ended = None if twist.yaw or at - last.at < RESTS else (at, speed.yaw)
        self.fastest = max(self.fastest, 2 * math.hypot(twist.x, twist.y, twist.z))
        self.fastest_turn = max(self.fastest_turn, 2 * abs(twist.yaw))

    def place_at(self, now: float) -> Standing:
        """Return its ideal and its measured place. A pose counts longer if its source sends it only after a move."""
        raw = self.latest
        known = raw and (now - raw.at <= FRESH or raw.source == AFTER_MOVING)
        return Standing(self.legs[-1].pose_at(now), raw.pose if raw and known else None)

    def jump(self, raw: RawPose) -> tuple[float, float] | None:
        """Return the distance between a pose and the one before, if the robot can't have moved so far."""
        before, profile = self.latest, self.profile
        if raw.source == SIMULATED or not before or raw.at <= before.at:
            return None
        passed, (far, turn) = raw.at - before.at + UNEVEN, raw.pose.apart(before.pose)
        fastest = BEYOND * profile.max_linear if profile.max_linear else self.fastest
        fastest_turn = BEYOND * profile.max_angular if profile.max_angular else self.fastest_turn
        is_near = far < JUMP + fastest * passed and turn < JUMP_TURN + fastest_turn * passed
        return None if is_near else (far, turn)

    def take(self, raw: RawPose, counts: bool) -> Comparison | None:
        jump = self.jump(raw)
        jumped = jump and raw.source == CONTINUOUS and not self.in_world
        before, self.latest = self.latest, raw
        if raw.at < self.since or (before and raw.at <= before.at):
            return None
        if self.in_world:
            self.frame = Pose()
            if jump:
                self.jumped = raw.at
        elif jumped and before and self.frame:
            self.frame = self.frame.then(before.pose).then(raw.pose.inverse())
        elif self.frame is None:
            stood = before if before and not jumped and raw.at - before.at <= OLDEST else raw
            self.frame = self._ideal(max(stood.at, self.since)).then(stood.pose.inverse())
        pose = (Pose() if raw.source == SIMULATED else self.frame).then(raw.pose)
        recent = tuple(self._ideal(max(raw.at - lag, self.since)) for lag in reversed(LAGS))
        ideal = self._ideal(raw.at)
        turned = math.remainder(pose.heading - ideal.heading, math.tau)
        pose = Pose(pose.x, pose.y, pose.z, ideal.heading + turned)
        if self.limits and (raw.source != SIMULATED or self.profile.dynamics == "motors"):
            taken = self.taken_at(raw)
            then = max(taken, self.since)
            speed = self._speed(self._leg(then), then)
            self.error = before_stopping(self._ideal(then), speed, self.accelerations, self.late), pose, taken
            if self.ended and then >= self.ended[0] + RESTS:
                if counts and self._fresh(raw.at):
                    off = math.remainder(self.error[0].heading - pose.heading, math.tau)
                    self.late = learned(self.late, off, self.ended[1], self.limits[1])
                self.ended = None
        follows = counts and self.correction(self.legs[-1].twist, raw.at) != STILL
        return Comparison(raw, pose, ideal, self.aligned, follows, recent, jump)

    def correction(self, twist: Twist, at: float) -> Twist:
        """Return the twist to add to a velocity, or zero if the latest pose is too old."""
        if not self.limits or not (error := self._fresh(at)):
            return STILL
        expected, measured, _ = error
        return correction(expected, self.profile.limited(twist), measured, self.limits, self.profile.turning_radius)

    def _fresh(self, at: float) -> tuple[Pose, Pose, float] | None:
        """Return the error unless its poses are too old or may be those of another robot."""
        return self.error if self.error and at - self.error[2] <= OLDEST and at >= self.jumped + DOUBTFUL else None

    def taken_at(self, raw: RawPose) -> float:
        """Return the time at which a pose was measured."""
        at = raw.at
        if raw.source == AFTER_MOVING and self.legs[-1].twist == STILL:
            return at  # it may have been kept for us since the robot moved last
        if raw.stamp is not None:
            self.least = min(self.least, raw.at - raw.stamp)
            at = min(raw.stamp, raw.at) if AHEAD <= self.least <= BEHIND else raw.at
        self.youngest = min(self.youngest, raw.at - at)
        return at

    def _speed(self, leg: _Leg, at: float) -> Twist:
        """Return the speed of its motors at a time within a leg."""
        return accelerated(leg.speed, self.profile.limited(leg.twist), at - leg.at, self.accelerations)

    def _ideal(self, at: float) -> Pose:
        """Return the robot's ideal pose. Forgets legs from long before: times only increase, except by the `LAGS`."""
        while len(self.legs) > 1 and self.legs[1].at <= at - LAGS[-1]:
            self.legs.popleft()
        return self._leg(at).pose_at(at)

    def _leg(self, at: float) -> _Leg:
        return next((leg for leg in reversed(self.legs) if leg.at <= at), self.legs[0])
