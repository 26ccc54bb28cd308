"""Trajectories as goals of a controller's action, FollowJointTrajectory (control_msgs; the node is passed in).

The wheels lack control_msgs; where ROS has it, a controller says that it refuses or aborts a trajectory, and why. Each
goal replaces the one before, and ends at rest, as the trajectories on its topic do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import Any
from uuid import uuid4

from improv_core.outputs.ros.topic import Now
from improv_core.plain import message as printed

NAME = "follow_joint_trajectory"
"""The name of the action, in the namespace of a controller's node."""
QUIET = 2.0
"""Seconds after which a refused or aborted trajectory no longer counts."""
OVERDUE = 0.5
"""Seconds after which a controller that hasn't answered doesn't serve the action, until it does."""
MAX_GOALS = 100
"""Goals whose results are awaited, at most."""
ABORTED = 6
"""The status of a goal that ended like that: STATUS_ABORTED of action_msgs/msg/GoalStatus."""

VIOLATED = -4, -5
"""The result codes of a goal that has failed, not of one that another goal replaced: PATH_TOLERANCE_VIOLATED and
GOAL_TOLERANCE_VIOLATED of control_msgs."""


class Goals:
    """The goals that the controller on a topic gets. Nothing here blocks; the executor that spins `node` receives the
    responses. A goal waits until the controller has answered the one before, so none piles up at a slow one."""

    def __init__(self, node: Any, topic: str, now: Now) -> None:
        from control_msgs.action import FollowJointTrajectory

        self._node, self._now = node, now
        self._action = FollowJointTrajectory
        kinds = FollowJointTrajectory.Impl
        self._sending, self._ending, self._canceling = (
            node.create_client(kind, f"{topic.rpartition('/')[0]}/{NAME}/_action/{name}")
            for kind, name in (
                (kinds.SendGoalService, "send_goal"),
                (kinds.GetResultService, "get_result"),
                (kinds.CancelGoalService, "cancel_goal"),
            )
        )
        self._live: dict[bytes, Any] = {}  # goals that haven't ended, and their latest responses
        self._latest: bytes | None = None  # the goal sent last; None after a stop
        self._asked = math.inf  # since when it is unanswered
        self._next: bytes | None = None  # the trajectory that waits
        self._accepted: bytes | None = None  # the latest goal that the controller has accepted and not replaced
        self._problem, self._since = "", -math.inf

    @property
    def serves(self) -> bool:
        """True if the controller serves the action now."""
        ready = self._now() < self._asked + OVERDUE
        return ready and all(each.service_is_ready() for each in (self._sending, self._ending, self._canceling))

    @property
    def problem(self) -> str:
        """The controller's recent refusal or abort, in words that follow its name; "" if there is none."""
        return self._problem if self._now() < self._since + QUIET else ""

    def send(self, message: bytes) -> None:
        """Send a trajectory, a serialized message, which replaces the one before."""
        if self._asked < math.inf:
            self._next = message
            return
        from rclpy.serialization import deserialize_message
        from trajectory_msgs.msg import JointTrajectory

        goal = self._latest = uuid4().bytes
        request = self._sending.srv_type.Request(goal=self._action.Goal())
        request.goal_id.uuid = [*goal]
        request.goal.trajectory = deserialize_message(message, JointTrajectory)
        if len(self._live) >= MAX_GOALS:  # its server never says how goals end
            self._live.pop(next(iter(self._live))).cancel()
        self._asked = self._now()
        self._live[goal] = self._sending.call_async(request)
        self._live[goal].add_done_callback(partial(self._answered, goal))

    def stop(self, after: float) -> None:
        """Cancel all goals after some seconds, in which joints brake by another message."""
        self._latest, self._accepted, self._next, goals = None, None, None, [*self._live]
        if not after:
            self._cancel(goals)
        elif goals:
            from rclpy.clock import Clock, ClockType

            def act() -> None:
                timer.cancel()
                self._cancel(goals)
                self._node.destroy_timer(timer)

            timer = self._node.create_timer(after, act, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _answered(self, goal: bytes, response: Any) -> None:
        self._take_answer(goal, response)
        waiting, self._next, self._asked = self._next, None, math.inf
        if waiting is not None:
            self.send(waiting)

    def _take_answer(self, goal: bytes, response: Any) -> None:
        if goal not in self._live or response.exception() or not response.result().accepted:
            self._live.pop(goal, None)
            if goal == self._latest:
                self._problem, self._since = "refuses what it gets: its log says why", self._now()
            return
        request = self._ending.srv_type.Request()
        request.goal_id.uuid = [*goal]
        self._live[goal] = self._ending.call_async(request)
        self._live[goal].add_done_callback(partial(self._ended, goal))
        if self._latest is None:  # a stop has overtaken it
            self._cancel([goal])
        else:
            self._accepted = goal

    def _ended(self, goal: bytes, response: Any) -> None:
        self._live.pop(goal, None)
        if self._latest is None or response.cancelled() or response.exception():
            return
        status, result = response.result().status, response.result().result
        # The end of a goal that is replaced may arrive before the answer about the one that replaces it.
        is_latest = goal == self._accepted and self._asked == math.inf
        if status == ABORTED and (is_latest or result.error_code in VIOLATED):
            why = printed(result.error_string) or f"its code is {result.error_code}"
            self._problem, self._since = f"has aborted what it got: {why}", self._now()

    def _cancel(self, goals: Iterable[bytes]) -> None:
        for goal in goals:
            if goal in self._live:
                request = self._canceling.srv_type.Request()
                request.goal_info.goal_id.uuid = [*goal]
                self._canceling.call_async(request)
