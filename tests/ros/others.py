"""Other nodes, run by ROS's interpreter until its input ends: listeners, publishers, services that reset robots.

One process has many nodes: a process takes a second to start, and others find one that runs at once. Each line of input
is `[number, command, options]`, each line of output `[number, message]`. Each node has its own context, so others find
it as they would find a process; one context can't have two types on one topic.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from collections.abc import Callable
from functools import reduce
from importlib import import_module
from typing import Any

import own_output  # noqa: F401, before any library may print
import rclpy
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_srvs.srv import Empty

TWISTS = "geometry_msgs/Twist", "geometry_msgs/TwistStamped"
POSES = "nav_msgs/Odometry", "geometry_msgs/PoseStamped"

speaking = threading.Lock()


def say(number: int, **what: Any) -> None:
    with speaking:
        print(json.dumps([number, what]), flush=True)


class Nodes:
    """Nodes by their names and domains, each with a thread that spins it."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, int | None], tuple[Any, Any, threading.Thread]] = {}

    def do(self, name: str, domain: int | None, work: Callable[[Any], Any]) -> Any:
        """Do something with a node on its own thread, so nothing is made or destroyed while that thread waits."""
        node, executor, _ = self._get(name, domain)
        task = executor.create_task(work, node)
        done = threading.Event()
        task.add_done_callback(lambda _: done.set())
        done.wait()
        return task.result()

    def _get(self, name: str, domain: int | None) -> tuple[Any, Any, threading.Thread]:
        if (name, domain) not in self._made:
            context = rclpy.Context()
            rclpy.init(context=context, domain_id=domain)
            node = rclpy.create_node(name, context=context)
            executor = SingleThreadedExecutor(context=context)
            executor.add_node(node)
            spinning = threading.Thread(target=executor.spin)
            spinning.start()
            self._made[name, domain] = node, executor, spinning
        return self._made[name, domain]

    def close(self, domain: int | None = None) -> None:
        """Close the nodes in a domain, or all."""
        for key, (node, executor, spinning) in list(self._made.items()):
            if domain is None or key[1] == domain:
                # A thread still inside rclpy when Python ends would abort the process.
                executor.shutdown()
                rclpy.try_shutdown(context=node.context)
                spinning.join()
                node.destroy_node()
                del self._made[key]


def kind(name: str) -> Any:
    package, _, message = name.partition("/")
    return getattr(import_module(f"{package}.msg"), message)


def quality(depth: int, options: dict[str, Any]) -> QoSProfile:
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.BEST_EFFORT if options.get("best_effort") else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if options.get("latched") else DurabilityPolicy.VOLATILE,
    )


class Listener:
    """A subscriber that reports messages, their times, and the number of publishers. With `reset`, it offers a service
    that resets as turtlesim's does: it makes each subscription again. A `deaf` one never answers."""

    def __init__(self, number: int, node: Any, options: dict[str, Any]) -> None:
        self._number, self._node, self._options = number, node, options
        self._reads = reader_of(options["type"])
        self._publishers = dict.fromkeys(options["topics"], 0)
        self._closing = threading.Event()
        self._service = options.get("reset") and node.create_service(Empty, options["reset"], self._reset)
        self._listen()

    def _listen(self) -> None:
        def listen(topic: str) -> Any:
            def hear(message: Any) -> None:
                say(self._number, topic=topic, at=time.monotonic(), **self._reads(message))

            def count(match: Any) -> None:
                self._publishers[topic] = match.current_count
                say(self._number, publishers=max(self._publishers.values()))

            return self._node.create_subscription(
                kind(self._options["type"]),
                topic,
                hear,
                quality(100, self._options),
                event_callbacks=SubscriptionEventCallbacks(matched=count),
            )

        self._subscriptions = [listen(topic) for topic in self._options["topics"]]

    def _reset(self, _: Any, response: Any) -> Any:
        say(self._number, topic=self._options["reset"], at=time.monotonic())
        if self._options.get("deaf"):
            self._closing.wait()
        else:
            self._destroy_subscriptions()
            self._listen()
        return response

    def _destroy_subscriptions(self) -> None:
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)

    def leave(self) -> None:
        """Leave, from another thread than the node's."""
        self._closing.set()

    def close(self) -> None:
        self._destroy_subscriptions()
        if self._service:
            self._node.destroy_service(self._service)


def reader_of(name: str) -> Callable[[Any], dict[str, Any]]:
    """Return a function that makes the report of a message of this type."""
    if name in POSES:
        return pose
    if name == "sensor_msgs/JointState":
        return lambda message: {"positions": dict(zip(message.name, message.position, strict=True))}
    if name == "trajectory_msgs/JointTrajectory":
        return trajectory
    return velocity if name in TWISTS else plain


def plain(value: Any) -> Any:
    """Return a message, or a part of one, as JSON has it."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return ord(value)
    return value if isinstance(value, str | float | int) else [plain(each) for each in value]


def trajectory(message: Any) -> dict[str, Any]:
    points = [
        [each.time_from_start.sec + each.time_from_start.nanosec / 1e9, [*each.positions], [*each.velocities]]
        for each in message.points
    ]
    return {"joints": [*message.joint_names], "points": points}


def velocity(message: Any) -> dict[str, Any]:
    stamp = {}
    if hasattr(message, "header"):
        stamp = {"stamp": message.header.stamp.sec + message.header.stamp.nanosec / 1e9}
        message = message.twist
    linear, angular = message.linear, message.angular
    return {"x": linear.x, "y": linear.y, "z": linear.z, "yaw": angular.z, **stamp}


def pose(message: Any) -> dict[str, Any]:
    found = message.pose.pose if hasattr(message, "child_frame_id") else message.pose
    heading = 2 * math.atan2(found.orientation.z, found.orientation.w)
    return {"x": found.position.x, "y": found.position.y, "heading": heading}


class Publisher:
    """A publisher that repeats the latest fields at the rate `hz`, or sends them once. No fields are silence."""

    def __init__(self, number: int, node: Any, options: dict[str, Any]) -> None:
        self._number, self._node = number, node
        self._kind = kind(options["type"])
        self._publisher = node.create_publisher(self._kind, options["topic"], quality(10, options))
        self._latest: Any = None
        self._timer = node.create_timer(1 / options["hz"], self._repeat)

    def publish(self, fields: dict[str, Any] | None, once: bool) -> None:
        message = fields if fields is None else self._message(fields)
        self._latest = None if once else message
        if message is not None:
            self._publisher.publish(message)

    def _message(self, fields: dict[str, Any], name: str = "") -> Any:
        """Return a message with these fields; those of a message in a list name its type, too."""
        message = kind(name)() if name else self._kind()
        for path, value in fields.items():
            *outer, last = path.split(".")
            if isinstance(value, list) and value and isinstance(value[0], dict):
                value = [self._message(each["fields"], each["type"]) for each in value]
            setattr(reduce(getattr, outer, message), last, value)
        return message

    def _repeat(self) -> None:
        if (message := self._latest) is not None:
            self._publisher.publish(message)

    def leave(self) -> None:
        self._latest = None

    def close(self) -> None:
        self._node.destroy_timer(self._timer)
        self._node.destroy_publisher(self._publisher)


def main() -> None:
    nodes, made = Nodes(), dict[int, tuple[Any, str, int | None]]()
    try:
        obey(nodes, made)
    finally:
        for member, _, _ in made.values():
            member.leave()
        nodes.close()


def obey(nodes: Nodes, made: dict[int, tuple[Any, str, int | None]]) -> None:
    kinds: dict[str, Any] = {"listener": Listener, "publisher": Publisher}
    for line in sys.stdin:
        number, what, options = json.loads(line)
        if what in kinds:
            name, domain = options["name"], options["domain"]
            member = nodes.do(name, domain, lambda node: kinds[what](number, node, options))  # noqa: B023
            made[number] = member, name, domain
        elif what == "publish":
            made[number][0].publish(**options)
        elif what == "close":
            member, name, domain = made.pop(number)
            member.leave()
            nodes.do(name, domain, lambda _: member.close())  # noqa: B023
        elif what == "leave":
            nodes.close(options["domain"])
        say(number, done=True)


main()
