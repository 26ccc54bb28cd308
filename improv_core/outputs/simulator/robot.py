"""A simulated robot: its motion, its joints, its trail, and its pending setpoints. Standard library only."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from improv_core.outputs.simulator.collisions import Disc, Pushed
from improv_core.score.body import Body
from improv_core.score.dynamics import Motion, Motors, follow, motors_of
from improv_core.score.joints import JointMotion
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import Part

MAX_PLACES = 20_000
"""The most places kept in one trail: an hour and a half, if the robot changes its movement four times a second."""
SHARPEST = 1.0
"""The most radians that a robot turns between two places. Below half a turn, only one arc joins two poses."""


@dataclass(slots=True)
class SimulatedRobot:
    """A robot's state at its latest change, and its setpoints from then on."""

    part: Part
    motion: Motion
    trail: Trail
    joints: SimulatedJoints
    motors: Motors | None = field(init=False)
    disc: Disc = field(init=False)
    setpoints: deque[tuple[float, Twist]] = field(default_factory=deque)
    commanded: Twist = STILL
    """The latest twist that was sent to it."""
    pushed: Pushed | None = None
    """Set while something blocks the robot's path."""
    bumped: bool = False
    """True after a bump, until the robot leaves what it hit or moves away."""

    def __post_init__(self) -> None:
        self.become(self.part)

    def become(self, part: Part) -> None:
        """Play another part from where it is."""
        self.part, self.motors = part, motors_of(part.profile, part.robot)
        self.disc = Disc(part.profile.radius, self.motors is not None)
        self.joints.become(part.profile.body)

    def ahead(self, to: float) -> Motion:
        return follow(self.motion, self.setpoints, to, self.motors)

    def settle(self, to: float) -> None:
        """Drop the history up to `to`, except the trail."""
        self.leave_trail(to)
        self.motion = self.ahead(to)
        while self.setpoints and self.setpoints[0][0] <= to:
            self.setpoints.popleft()

    def leave_trail(self, to: float) -> None:
        """Add the robot's position at each change of its setpoint up to `to` to the trail."""
        for at, _ in self.setpoints:
            if at > to:
                break
            if at > self.trail.until:
                self.trail.add(at, self.pose_at(at))

    def mark(self, at: float) -> None:
        """Add the robot's position to the trail, unless the robot is still on the same arc."""
        self.leave_trail(at)
        if self.motors or self.pushed:
            self.trail.add(at, self.pose_at(at))
        else:
            self.trail.bend(at, self.pose_at(at))
        self.trail = self.trail.renewed()

    def speed_at(self, time: float) -> float:
        if self.pushed:
            return math.hypot(self.pushed.x, self.pushed.y)
        twist = self.ahead(time).twist
        return math.hypot(twist.x, twist.y, twist.z)

    def pose_at(self, time: float) -> Pose:
        ideally = self.ahead(time).pose_at(time)
        if not self.pushed:
            return ideally
        # Its own twist would take it into what it touches, so it keeps moving as in the last step.
        at, seconds = self.pushed.pose, time - self.motion.at
        return Pose(at.x + self.pushed.x * seconds, at.y + self.pushed.y * seconds, ideally.z, ideally.heading)


class TimedPose(NamedTuple):
    """A robot's pose in meters and radians, `at` seconds after beat 0."""

    at: float
    x: float
    y: float
    heading: float


class Trail:
    """The places of one robot, oldest first. Between two places, it moved along the one arc that joins their poses.

    A trail only grows, at its end, so any thread may read it. `until` is the time of the latest place in seconds.
    """

    def __init__(self, at: float, pose: Pose) -> None:
        self.until = -math.inf
        self.places: list[TimedPose] = []
        self.add(at, pose)

    def add(self, at: float, pose: Pose) -> None:
        """Add the robot's pose. While it stands, only its arrival and its departure are added."""
        here = TimedPose(at, pose.x, pose.y, pose.heading)
        stood = len(self.places) > 1 and self.places[-1][1:] == self.places[-2][1:] == here[1:]
        if at > self.until and not stood:
            self.places.append(here)
        self.until = max(at, self.until)

    def bend(self, at: float, pose: Pose) -> None:
        """Add the pose of a robot on an arc if it has turned far since the latest place."""
        if abs(pose.heading - self.places[-1].heading) > SHARPEST:
            self.add(at, pose)

    def renewed(self) -> Trail:
        """Return the trail without its older half if it has too many places."""
        if len(self.places) <= MAX_PLACES:
            return self
        trail = Trail(self.until, Pose())
        trail.places = self.places[MAX_PLACES // 2 :]
        return trail


class SimulatedJoints:
    """The joints of one robot, moved by its commands. Times are performance times, in seconds.

    Each joint moves at a constant velocity from where its command placed it, and stops at its limits. So its position
    never drifts, no matter how often it is read.
    """

    def __init__(self, body: Body | None) -> None:
        self.body: Body | None = None
        self._commands: dict[str, deque[tuple[float, JointMotion]]] = {}
        self.become(body)

    def become(self, body: Body | None) -> None:
        """Replace the joints. Joints that exist in both bodies keep their positions; new ones are at their starts."""
        self.body = body
        joints = body.joints if body else ()
        self._commands = {
            joint.name: self._commands.get(joint.name) or deque([(0.0, JointMotion(joint.within(joint.start), 0.0))])
            for joint in joints
        }

    def tell(self, joints: Mapping[str, JointMotion], at: float) -> None:
        """Move joints from a time on. Joints that the robot doesn't have anymore are ignored."""
        for name, motion in joints.items():
            if name in self._commands:
                self._commands[name].append((at, motion))

    def positions(self, now: float) -> dict[str, float]:
        """The positions of all joints, in radians or meters. After this call, earlier times are forgotten."""
        assert self.body
        found = {}
        for name, told in self._commands.items():
            while len(told) > 1 and told[1][0] <= now:
                told.popleft()
            at, motion = told[0]
            found[name] = motion.after(max(now - at, 0.0), self.body.joint[name])
        return found
