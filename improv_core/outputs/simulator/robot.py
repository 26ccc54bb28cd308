"""A simulated robot: its motion, its trail, and the setpoints that it has yet to follow. Standard library only."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

from improv_core.outputs.simulator.collisions import Disc, Pushed
from improv_core.outputs.simulator.joints import SimulatedJoints
from improv_core.outputs.simulator.trails import Trail
from improv_core.score.dynamics import Motion, Motors, follow
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import Part


@dataclass(slots=True)
class SimulatedRobot:
    """A robot as of its latest change, and its setpoints from then on."""

    part: Part
    disc: Disc
    motors: Motors | None
    motion: Motion
    trail: Trail
    joints: SimulatedJoints
    setpoints: deque[tuple[float, Twist]] = field(default_factory=deque)
    commanded: Twist = STILL
    """The last twist it was sent."""
    pushed: Pushed | None = None
    """Set while something keeps it from going where it wants."""
    bumped: bool = False
    """Whether it bumped into something, and has neither left that nor moved otherwise since."""

    def ahead(self, to: float) -> Motion:
        return follow(self.motion, self.setpoints, to, self.motors)

    def settle(self, to: float) -> None:
        """Drop the history up to `to`, of which only the trail is kept."""
        self.leave_trail(to)
        self.motion = self.ahead(to)
        while self.setpoints and self.setpoints[0][0] <= to:
            self.setpoints.popleft()

    def leave_trail(self, to: float) -> None:
        """Add to the trail where the robot has been told to move differently, up to `to`."""
        for at, _ in self.setpoints:
            if at > to:
                break
            if at > self.trail.until:
                self.trail.add(at, self.pose_at(at))

    def mark(self, at: float) -> None:
        """Add to the trail where the robot is, unless it is on the arc that it was on before."""
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
        # Its own twists would take it into what it touches, so it keeps moving as in the last step.
        at, seconds = self.pushed.pose, time - self.motion.at
        return Pose(at.x + self.pushed.x * seconds, at.y + self.pushed.y * seconds, ideally.z, ideally.heading)
