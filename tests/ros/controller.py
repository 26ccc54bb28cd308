"""Controllers of joints, run by ROS's interpreter: they behave as ros2_control's documentation says.

A trajectory controller follows control.ros.org on joint_trajectory_controller (Jazzy: its page, its parameters,
and "Trajectory Representation"): it obeys a trajectory as soon as it comes instead of the last, is cubic from where its
joints are to the first point and between points with positions and velocities, and holds the last point. By its
defaults, it refuses a trajectory that lacks a joint or ends in motion, and one whose times don't increase. One without
points stops nothing (ros2_controllers#683). Velocity and position controllers follow it on forward_command_controller:
they keep the latest command forever (ros2_controllers#95).

Each is a node with a parameter `joints` and listens on /NAME/CONTROLLER_controller/…, and /NAME/joint_states has the
positions of all joints fifty times a second. The process prints a line once they listen, and ends with its input; then
it prints how many trajectories were refused, and how goals ended.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import threading
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

PERIOD = 0.02
"""Seconds between two messages with the positions of joints."""

TOLERANCE = 0.05
"""Radians by which joints may be away from a goal."""

REPLACED = "a new goal replaces it"

Point = tuple[float, Sequence[float], Sequence[float]]
"""A point: seconds from the beginning, positions, and velocities."""


def cubic(begin: tuple[float, float], end: tuple[float, float], whole: float, passed: float) -> tuple[float, float]:
    """Return the position and the velocity between two of them, `whole` seconds apart."""
    (p, v), (q, w), share = begin, end, passed / whole
    square, cube = share**2, share**3
    position = (2 * cube - 3 * square + 1) * p + (3 * square - 2 * cube) * q
    position += whole * ((cube - 2 * square + share) * v + (cube - square) * w)
    slope = 6 * (q - p) * (share - square) / whole
    return position, slope + (3 * square - 4 * share + 1) * v + (3 * square - 2 * share) * w


@dataclass
class TrajectoryController:
    """A controller that follows trajectories. Times are monotonic, in seconds."""

    joints: Sequence[str]
    positions: list[float]
    _points: Sequence[Point] = ()
    _began: float = 0.0
    _state: Sequence[tuple[float, float]] = ()
    refused: list[str] = field(default_factory=list)
    inactive: bool = False

    def take(self, names: Sequence[str], points: Sequence[Point], now: float) -> None:
        if not points:
            return
        if self.inactive:
            self.refused.append("it is inactive")
        elif sorted(names) != sorted(self.joints):
            self.refused.append("it lacks a joint")
        elif any(points[-1][2]):
            self.refused.append("it ends in motion")
        elif any(later <= earlier for (earlier, _, _), (later, _, _) in pairwise(points)):
            self.refused.append("its times don't increase")
        else:
            self._state = self.states(now)
            order = [names.index(joint) for joint in self.joints]
            self._points = [(at, [p[each] for each in order], [v[each] for each in order]) for at, p, v in points]
            self._began = now

    def hold(self, now: float) -> None:
        """Have joints stand where they are."""
        self.positions, self._points = [position for position, _ in self.states(now)], ()

    def states(self, now: float) -> list[tuple[float, float]]:
        """The position and the velocity of each joint."""
        points, passed = self._points, now - self._began
        if not points:
            return [(position, 0.0) for position in self.positions]
        if passed < points[0][0]:
            positions, velocities = zip(*self._state, strict=True)
            points = [(0.0, positions, velocities), *points]
        for (begin, p, v), (end, q, w) in pairwise(points):
            if begin <= passed < end:
                pairs = zip(zip(p, v, strict=True), zip(q, w, strict=True), strict=True)
                return [cubic(one, other, end - begin, passed - begin) for one, other in pairs]
        return [(position, 0.0) for position in points[-1][1]]


@dataclass
class ForwardController:
    """A controller that keeps each command until the next one. Times are monotonic, in seconds."""

    joints: Sequence[str]
    positions: list[float]
    interface: str
    _velocities: Sequence[float] = ()
    _since: float = 0.0

    def take(self, numbers: Sequence[float], now: float) -> None:
        if len(numbers) != len(self.joints):
            return
        self.positions = [position for position, _ in self.states(now)]
        if self.interface == "position":
            self.positions = [*numbers]
        else:
            self._velocities, self._since = [*numbers], now

    def states(self, now: float) -> list[tuple[float, float]]:
        """The position and the velocity of each joint."""
        velocities = self._velocities or [0.0] * len(self.joints)
        passed = now - self._since
        return [(p + v * passed, v) for p, v in zip(self.positions, velocities, strict=True)]


class TrajectoryAction:
    """The action of a trajectory controller, as joint_trajectory_controller serves it: a goal replaces the one before,
    which then counts as aborted, and one that is canceled has its joints stand where they are.

    It aborts a goal whose joints are too far from it. `ends` says how goals have ended.
    """

    def __init__(self, node: Any, name: str, controller: TrajectoryController) -> None:
        from control_msgs.action import FollowJointTrajectory
        from rclpy.action import ActionServer, CancelResponse, GoalResponse
        from rclpy.task import Future

        self._controller = controller
        self._future: Any = None
        self._until = 0.0
        self.ends: list[str] = []

        def begin(goal: Any) -> Any:
            refused = len(controller.refused)
            trajectory = goal.trajectory
            controller.take(trajectory.joint_names, points_of(trajectory), time.monotonic())
            return GoalResponse.REJECT if len(controller.refused) > refused else GoalResponse.ACCEPT

        def cancel(handle: Any) -> Any:
            self._controller.hold(time.monotonic())
            self._end("canceled", "")
            return CancelResponse.ACCEPT

        def accept(handle: Any) -> None:
            self._end("aborted", REPLACED)
            last = handle.request.trajectory.points[-1].time_from_start
            future, self._until = Future(), time.monotonic() + last.sec + last.nanosec / 1e9

            async def execute(handle: Any) -> Any:
                how, why = await future
                if how == "canceled" and handle.is_cancel_requested:  # not if a new goal came in the same moment
                    handle.canceled()
                else:
                    (handle.succeed if how == "succeeded" else handle.abort)()
                code = {"": 0, REPLACED: -1}.get(why, -4)
                return FollowJointTrajectory.Result(error_code=code, error_string=why)

            self._future = future
            handle.execute(execute)

        self._server = ActionServer(
            node,
            FollowJointTrajectory,
            name,
            execute_callback=lambda handle: None,
            goal_callback=begin,
            cancel_callback=cancel,
            handle_accepted_callback=accept,
        )

    def proceed(self, real: Mapping[str, float]) -> None:
        """End a goal that is reached, or whose joints are really elsewhere."""
        now = time.monotonic()
        for joint, (position, _) in zip(self._controller.joints, self._controller.states(now), strict=True):
            if abs(position - real.get(joint, position)) > TOLERANCE:
                self._controller.hold(now)
                return self._end("aborted", f"{joint} violated its path tolerance")
        if now >= self._until:
            self._end("succeeded", "")
        return None

    def _end(self, how: str, why: str) -> None:
        if self._future:
            self.ends.append(how)
            self._future.set_result((how, why))
            self._future = None


def points_of(trajectory: Any) -> list[Point]:
    return [
        (each.time_from_start.sec + each.time_from_start.nanosec / 1e9, each.positions, each.velocities)
        for each in trajectory.points
    ]


Made = TrajectoryController | ForwardController


def make(interface: str, joints: Sequence[str], starts: Mapping[str, float]) -> Made:
    positions = [starts.get(joint, 0.0) for joint in joints]
    if interface == "trajectory":
        return TrajectoryController(joints, positions)
    return ForwardController(joints, positions, interface)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("robot")
    parser.add_argument("--controller", nargs="+", action="append", help="its name, its interface, and its joints")
    for name, about in (
        ("--start", "a joint, and where it is, in radians"),
        ("--jam", "a joint, and the position that it doesn't pass"),
    ):
        parser.add_argument(name, nargs=2, action="append", default=[], help=about)
    parser.add_argument("--inactive", action="append", default=[], help="a controller that refuses everything")
    parser.add_argument("--action", action="append", default=[], help="a controller that serves FollowJointTrajectory")
    parser.add_argument("--deaf", action="append", default=[], help="a controller that has no topic")
    options = parser.parse_args()
    starts, jams = ({joint: float(number) for joint, number in each} for each in (options.start, options.jam))

    import own_output  # noqa: F401, before any library may print
    import rclpy
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray
    from trajectory_msgs.msg import JointTrajectory

    rclpy.init()
    node = rclpy.create_node("joint_state_broadcaster", namespace=options.robot)
    nodes = [node]
    states = node.create_publisher(JointState, f"/{options.robot}/joint_states", 10)
    made: list[Made] = []
    actions: list[TrajectoryAction] = []
    real: dict[str, float] = dict(starts)

    def follow(joint: str, position: float) -> float:
        """Return where a joint really is."""
        real[joint] = min(position, jams.get(joint, math.inf))
        return real[joint]

    def listen(name: str, interface: str, joints: Sequence[str]) -> None:
        controller = make(interface, joints, starts)
        made.append(controller)
        if isinstance(controller, TrajectoryController):
            controller.inactive = name in options.inactive
        nodes.append(rclpy.create_node(f"{name}_controller", namespace=options.robot))
        nodes[-1].declare_parameter("joints", [*joints])
        topic = f"/{options.robot}/{name}_controller/"

        def hear_trajectory(message: Any) -> None:
            assert isinstance(controller, TrajectoryController)
            controller.take(message.joint_names, points_of(message), time.monotonic())

        def hear_numbers(message: Any) -> None:
            assert isinstance(controller, ForwardController)
            controller.take(message.data, time.monotonic())

        if name in options.action:
            assert isinstance(controller, TrajectoryController)
            actions.append(TrajectoryAction(nodes[-1], f"{topic}follow_joint_trajectory", controller))
        if name in options.deaf:
            pass
        elif interface == "trajectory":
            nodes[-1].create_subscription(JointTrajectory, f"{topic}joint_trajectory", hear_trajectory, 10)
        else:
            nodes[-1].create_subscription(Float64MultiArray, f"{topic}commands", hear_numbers, 10)

    def publish() -> None:
        message, now = JointState(), time.monotonic()
        message.header.stamp = node.get_clock().now().to_msg()
        for controller in made:
            found = controller.states(now)
            message.name = [*message.name, *controller.joints]
            moved = [follow(joint, at) for joint, (at, _) in zip(controller.joints, found, strict=True)]
            message.position = [*message.position, *moved]
            message.velocity = [*message.velocity, *(velocity for _, velocity in found)]
        states.publish(message)
        for action in actions:
            action.proceed(real)

    for name, interface, *joints in options.controller:
        listen(name, interface, joints)
    node.create_timer(PERIOD, publish)
    executor = SingleThreadedExecutor()
    for each in nodes:
        executor.add_node(each)

    def spin() -> None:
        with suppress(ExternalShutdownException):
            executor.spin()

    spinning = threading.Thread(target=spin)
    spinning.start()
    print("true", flush=True)
    sys.stdin.read()
    # A thread still inside rclpy when Python ends would abort the process.
    rclpy.try_shutdown()
    spinning.join()
    followers = [each for each in made if isinstance(each, TrajectoryController)]
    ended = Counter(end for action in actions for end in action.ends)
    print(json.dumps([sum(len(each.refused) for each in followers), ended]), flush=True)


if __name__ == "__main__":
    main()
