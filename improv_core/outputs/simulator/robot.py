"""A simulated robot: its motion, its trail, and its pending setpoints. Standard library only."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from improv_core.outputs.simulator.collisions import Disc, Pushed
from improv_core.outputs.simulator.joints import SimulatedJoints
from improv_core.outputs.simulator.trails import Trail
from improv_core.score.dynamics import Motion, Motors, follow, motors_of
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import Part


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
