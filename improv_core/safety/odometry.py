"""Where robots really are: their measured poses, compared with where the score has them. It never reads a clock.

All times are the clock's, in seconds. Standard library only.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from improv_core.protocol.messages import SIMULATED
from improv_core.protocol.output import RawPose
from improv_core.safety.preflight import Standing
from improv_core.score.dynamics import motors_of
from improv_core.score.following import OLDEST, accelerated, before_stopping, correction
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import DEFAULT, Profile, beside_robots
from improv_core.score.score import Part

RECENT = 0.2
"""Seconds: a pose this recent still shows where a robot stands when its frame is aligned."""
LEGS_KEPT = 1000
"""Changes of velocity that are remembered until a pose from after them arrives."""
JUMP, JUMP_TURN = 0.1, 0.3
"""Meters and radians that a robot can't move between two poses, beyond what its fastest velocity explains."""
LEAST_SPEED, LEAST_TURN = 1.0, 3.0
"""m/s and rad/s: if a robot's limits aren't known, moving this fast is never a jump, since somebody else may be driving
it."""
BEYOND = 1.5
"""How many times as fast as its limits a robot may move: wheels roll farther than they should, and slopes help."""
UNEVEN = 0.1
"""Seconds by which the time between two poses may seem too short, because the first of them came late."""
LAGS = (0.08, 0.16, 0.25)
"""Seconds by which a robot may be behind: its poses come late, and its motors need time. At 0.9 m/s² and 7.7 rad/s², a
TurtleBot3 that starts at its limits lags by 0.12 s and 0.18 s, and poses came 80 ms late."""
AHEAD, BEHIND = -0.05, 1.0
"""Seconds from a stamp to the arrival of its pose, at the least: if it is less or more, the clocks don't agree."""
DOUBTFUL = 10.0
"""Seconds after a jump in which poses in the world correct nothing: they may be those of another robot."""
FRESH = 1.0
"""Seconds: a robot stands where it was then, if it is told nothing."""
AFTER_MOVING = "geometry_msgs/PoseWithCovarianceStamped"
"""The source that sends a pose only after a robot has moved: localization on a map, such as AMCL."""
CONTINUOUS = "nav_msgs/Odometry"
"""The source whose frame never jumps (REP 105): if it does, it has started over. Others may correct themselves."""


class Comparison(NamedTuple):
    """Where a robot was at a time, and where it ideally was, both in the world of the score.

    `aligned` counts how often its frame was aligned with that world in this performance. Each time, its path begins
    again. `follows` tells whether it is pulled back to its ideal path. `recent` is where it ideally was a moment
    before, by each of the `LAGS`. `jump` is how far this pose is from the one before, in meters and radians, if it
    can't have moved so far.
    """

    raw: RawPose
    pose: Pose
    ideal: Pose
    aligned: int
    follows: bool
    recent: tuple[Pose, ...] = ()
    jump: tuple[float, float] | None = None


class Odometry:
    """Aligns the frames of measured poses with the world of the score, and knows where robots ideally are.

    Ideally, a robot obeys every velocity at once and exactly. A frame of its own is aligned at beat 0 and after a seek,
    so that it is then where the score has it. Poses in the world of the score are taken as they are.
    """

    def __init__(self) -> None:
        self._tracks: dict[str, _Track] = {}

    def begin(self, parts: Mapping[str, Part], at: float) -> None:
        """A performance begins with its robots at their starts."""
        latest = {robot: track.latest for robot, track in self._tracks.items()}
        self._tracks = {}
        self.cast(parts, at)
        for robot, track in self._tracks.items():
            track.latest = latest.get(robot)

    def cast(self, parts: Mapping[str, Part], at: float) -> None:
        """Another score plays. Robots that are new begin at their starts, and one that takes over the part of another
        begins where that one ideally is."""
        for robot in self._tracks.keys() - parts.keys():
            del self._tracks[robot]
        for robot, part in parts.items():
            if part.elsewhere or (not part.odom and part.profile.dynamics == "ideal"):
                self._tracks.pop(robot, None)
            else:
                if robot not in self._tracks:
                    self._tracks[robot] = _Track(at, part.entered or part.start)
                track = self._tracks[robot]
                if track.topic not in ("", part.topic):
                    track.place(track.legs[-1].pose_at(at), at)
                    track.latest = None  # another robot has been elsewhere, and hasn't jumped
                track.cast(part)

    def place(self, poses: Mapping[str, Pose], at: float) -> None:
        """Playback jumps to a beat at which the score has the robots at these poses."""
        for robot, pose in poses.items():
            if track := self._tracks.get(robot):
                track.place(pose, at)

    def tell(self, robot: str, twist: Twist, at: float) -> None:
        """A robot has been told to move."""
        if track := self._tracks.get(robot):
            track.tell(twist, at)

    def correction(self, robot: str, twist: Twist, at: float) -> Twist:
        """What to add to a velocity that a robot is told at this time, if it follows its ideal path."""
        track = self._tracks.get(robot)
        return track.correction(twist, at) if track else STILL

    def is_doubtful(self, robot: str, at: float) -> bool:
        """Whether the poses of a robot have jumped lately, so that they may be those of another one."""
        track = self._tracks.get(robot)
        return track is not None and at < track.jumped + DOUBTFUL

    def taken_at(self, raw: RawPose) -> float:
        """When a pose was measured: by its stamp if the clocks agree, as far as is known, and else when it came."""
        track = self._tracks.get(raw.robot)
        return track.taken_at(raw) if track else raw.at

    def ages(self) -> dict[str, float]:
        """How old poses were at least when they came, in seconds, of the robots of which some came since the last
        call."""
        found = {robot: track.youngest for robot, track in self._tracks.items() if track.youngest < math.inf}
        for robot in found:
            self._tracks[robot].youngest = math.inf
        return found

    def clocks(self) -> dict[str, float]:
        """By how many seconds the clocks that stamp robots' poses are ahead of ours at least, or less than 0, behind
        at most: of the robots whose clock doesn't agree."""
        known = {robot: track.least for robot, track in self._tracks.items() if track.least < math.inf}
        return {robot: -least for robot, least in known.items() if not AHEAD <= least <= BEHIND}

    def fits(self, raw: RawPose) -> bool:
        """Whether a pose is of the robot that has this part now: one of another may have been on its way."""
        track = self._tracks.get(raw.robot)
        return not (track and raw.topic) or raw.topic == track.odom

    def take(self, raw: RawPose) -> Comparison | None:
        """Take a pose and compare it with the ideal one; None if it can't be compared."""
        track = self._tracks.get(raw.robot)
        return track.take(raw) if track else None

    def places(self, now: float) -> dict[str, Standing]:
        """Where the robots should be and stand whose poses are in the world, at a time on the clock."""
        return {robot: track.place_at(now) for robot, track in self._tracks.items() if track.in_world}

    @property
    def robots(self) -> Collection[str]:
        """The robots whose poses are compared."""
        return self._tracks.keys()


class _Leg(NamedTuple):
    """Where a robot ideally is at a time, the velocity it ideally has from then on, and its motors' speed then."""

    at: float
    pose: Pose
    twist: Twist
    speed: Twist = STILL

    def pose_at(self, at: float) -> Pose:
        return self.pose.after(self.twist, at - self.at).above_ground()


@dataclass(slots=True)
class _Track:
    """One robot: its ideal path since the latest pose, and how its frame lies in the world (None: not known yet).

    A robot that is `in_world` has no frame of its own, so it need not begin where the score has it.
    If it follows that path, `limits` are its own, and `error` is where it should have been and was at a time.
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
    fastest: float = LEAST_SPEED
    fastest_turn: float = LEAST_TURN
    profile: Profile = DEFAULT
    accelerations: tuple[float, float] = (math.inf, math.inf)
    limits: tuple[float, float] | None = None
    error: tuple[Pose, Pose, float] | None = None
    least: float = math.inf  # seconds from a stamp to its arrival
    youngest: float = math.inf  # how old a pose was at least when it came, lately
    jumped: float = -math.inf  # when its poses in the world jumped last

    def __post_init__(self) -> None:
        self.legs = deque([_Leg(self.since, self.start, STILL)], LEGS_KEPT)

    def cast(self, part: Part) -> None:
        self.topic, self.odom = part.topic, part.odom
        self.profile = profile = part.profile
        motors = motors_of(beside_robots(profile), part.robot)
        self.accelerations = (motors.linear_acceleration, motors.angular_acceleration) if motors else (math.inf,) * 2
        linear, angular = profile.max_linear, profile.max_angular
        self.limits = (linear, angular) if part.follow and linear and angular else None
        if (in_world := part.odom_frame == "world") != self.in_world:
            self.in_world, self.frame, self.aligned = in_world, None, self.aligned + 1

    def place(self, pose: Pose, at: float) -> None:
        self.since, self.frame, self.aligned, self.error = at, None, self.aligned + 1, None
        self.legs = deque([_Leg(at, pose, STILL)], LEGS_KEPT)

    def tell(self, twist: Twist, at: float) -> None:
        last = self.legs[-1]
        if twist == last.twist:
            return
        at = max(at, last.at)
        self.legs.append(_Leg(at, last.pose_at(at), twist, self._speed(last, at)))
        self.fastest = max(self.fastest, 2 * math.hypot(twist.x, twist.y, twist.z))
        self.fastest_turn = max(self.fastest_turn, 2 * abs(twist.yaw))

    def place_at(self, now: float) -> Standing:
        """Where it should be and stands. A pose from a moment ago counts, and any that comes only after a movement."""
        raw = self.latest
        known = raw and (now - raw.at <= FRESH or raw.source == AFTER_MOVING)
        return Standing(self.legs[-1].pose_at(now), raw.pose if raw and known else None)

    def jump(self, raw: RawPose) -> tuple[float, float] | None:
        """How far a pose is from the one before, if the robot can't have moved so far."""
        before, profile = self.latest, self.profile
        if raw.source == SIMULATED or not before or raw.at <= before.at:
            return None
        passed, (far, turn) = raw.at - before.at + UNEVEN, raw.pose.apart(before.pose)
        fastest = BEYOND * profile.max_linear if profile.max_linear else self.fastest
        fastest_turn = BEYOND * profile.max_angular if profile.max_angular else self.fastest_turn
        is_near = far < JUMP + fastest * passed and turn < JUMP_TURN + fastest_turn * passed
        return None if is_near else (far, turn)

    def take(self, raw: RawPose) -> Comparison | None:
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
            stood = before if before and not jumped and raw.at - before.at <= RECENT else raw
            self.frame = self._ideal(max(stood.at, self.since)).then(stood.pose.inverse())
        pose = (Pose() if raw.source == SIMULATED else self.frame).then(raw.pose)
        recent = tuple(self._ideal(max(raw.at - lag, self.since)) for lag in reversed(LAGS))
        ideal = self._ideal(raw.at)
        turned = math.remainder(pose.heading - ideal.heading, math.tau)
        pose = Pose(pose.x, pose.y, pose.z, ideal.heading + turned)
        if self.limits and (raw.source != SIMULATED or self.profile.dynamics == "motors"):
            speed = self._speed(self._leg(raw.at), raw.at)
            self.error = before_stopping(ideal, speed, self.accelerations), pose, self.taken_at(raw)
        follows = self.correction(self.legs[-1].twist, raw.at) != STILL
        return Comparison(raw, pose, ideal, self.aligned, follows, recent, jump)

    def correction(self, twist: Twist, at: float) -> Twist:
        """What to add to a velocity, if the latest pose is not too old."""
        if not self.limits or not self.error or at - self.error[2] > OLDEST or at < self.jumped + DOUBTFUL:
            return STILL
        expected, measured, _ = self.error
        return correction(expected, self.profile.limited(twist), measured, self.limits, self.profile.turning_radius)

    def taken_at(self, raw: RawPose) -> float:
        """When a pose was measured."""
        at = raw.at
        if raw.stamp is not None:
            self.least = min(self.least, raw.at - raw.stamp)
            at = min(raw.stamp, raw.at) if AHEAD <= self.least <= BEHIND else raw.at
        self.youngest = min(self.youngest, raw.at - at)
        return at

    def _speed(self, leg: _Leg, at: float) -> Twist:
        """How fast its motors are at a time of a leg."""
        return accelerated(leg.speed, self.profile.limited(leg.twist), at - leg.at, self.accelerations)

    def _ideal(self, at: float) -> Pose:
        """Where the robot ideally is. What is from long before the leg of that time is forgotten: times only increase,
        except by the `LAGS`."""
        while len(self.legs) > 1 and self.legs[1].at <= at - LAGS[-1]:
            self.legs.popleft()
        return self._leg(at).pose_at(at)

    def _leg(self, at: float) -> _Leg:
        """The leg of a time."""
        return next((leg for leg in reversed(self.legs) if leg.at <= at), self.legs[0])
