"""The joints of a simulated robot: their exact positions at any time. Standard library only."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from improv_core.score.body import Body
from improv_core.score.joints import JointMotion


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
