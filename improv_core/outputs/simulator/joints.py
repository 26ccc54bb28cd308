"""The joints of a simulated robot: where they are at any time, exactly. Standard library only."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from improv_core.score.body import Body
from improv_core.score.joints import JointMotion


class SimulatedJoints:
    """The joints of one robot, as they were told to move. Times are performance times, in seconds.

    Each joint moves evenly from where it was told to be, so its position never drifts, no matter how often it is asked
    for, and stops at its limits.
    """

    def __init__(self, body: Body | None) -> None:
        self.body: Body | None = None
        self._told: dict[str, deque[tuple[float, JointMotion]]] = {}
        self.become(body)

    def become(self, body: Body | None) -> None:
        """Have these joints from now on. Those that it had before stay where they are; others are at their starts."""
        self.body = body
        joints = body.joints if body else ()
        self._told = {
            joint.name: self._told.get(joint.name) or deque([(0.0, JointMotion(joint.within(joint.start), 0.0))])
            for joint in joints
        }

    def tell(self, joints: Mapping[str, JointMotion], at: float) -> None:
        """Have joints move from a time on. Those that the robot no longer has are ignored."""
        for name, motion in joints.items():
            if name in self._told:
                self._told[name].append((at, motion))

    def positions(self, now: float) -> dict[str, float]:
        """Where all joints are, in radians or meters. Times before that can't be asked for any more."""
        assert self.body
        found = {}
        for name, told in self._told.items():
            while len(told) > 1 and told[1][0] <= now:
                told.popleft()
            at, motion = told[0]
            found[name] = motion.after(max(now - at, 0.0), self.body.joint[name])
        return found
