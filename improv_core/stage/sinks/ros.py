"""Velocities to ROS 2 topics, from one node that lives as long as the stage (rclpy, imported lazily)."""

from __future__ import annotations

import math
import os
import re
import socket
import threading
import time
from collections.abc import Callable, Collection, Mapping
from typing import Any

from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import Part, Score
from improv_core.stage.discovery import described, limited
from improv_core.stage.sinks.ros_reset import Resets
from improv_core.stage.sinks.ros_topic import Topic

DEPTH = 10
"""Messages kept for a slow listener, reliably: as teleop_twist_keyboard and Nav2 publish, so all listeners match."""
REST = 0.005
"""Seconds between two things received: /clock may come a thousand times a second, and its latest message is enough."""
LINGER = 0.2
"""Seconds to keep the publishers after the last zeros: a listener loses what it has not received when they go."""


class Ros:
    """A sink that publishes `geometry_msgs/Twist` or `TwistStamped`, within the limits of each robot's profile.

    `discovery` is how far it looks for robots where the environment does not say (stage/discovery.py).
    Raises ImportError if there is no rclpy.
    """

    name: str = "ROS 2"
    live: bool = True
    period: float | None = None

    def __init__(self, discovery: str | None) -> None:
        os.environ.update(limited(os.environ, discovery))
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        self._node = _node(rclpy.get_default_context(), _node_name())
        self._nodes = [self._node]
        self._executor: Any = SingleThreadedExecutor(context=rclpy.get_default_context())
        self._executor.add_node(self._node)
        self._closing = threading.Event()
        self._receiving = threading.Thread(target=self._receive, daemon=True)
        self._receiving.start()
        self._resets = Resets(self._node)
        self._parts: dict[str, Part] = {}
        self._topics: dict[str, Topic] = {}
        self._cast: list[str] = []
        self._uses_sim_time = False

    @property
    def description(self) -> str:
        """What is reached, in words: the domain and how far discovery goes."""
        return f"{self.name}, {described(os.environ)}"

    def prepare(self, score: Score, restart: bool) -> None:
        """Make publishers for new topics; those that are there are kept, since discovery takes up to seconds.

        With `restart`, the robots that have a reset service are stopped, and it is called.
        """
        parts = score.parts
        self._cast = list(parts)
        self._parts.update(parts)
        self._use_sim_time(any(part.use_sim_time for part in parts.values()))
        for part in parts.values():
            if part.topic in self._topics:
                self._topics[part.topic].take(part.profile.message)
            else:
                self._topics[part.topic] = Topic(
                    part.topic, part.profile.message, self._node, self._advertise, not restart
                )
        if restart:
            reset = [(part.reset, robot, self._topics[part.topic]) for robot, part in parts.items() if part.reset]
            for _, robot, _ in reset:
                self.send(robot, STILL, 0.0)
            self._resets.begin(reset)

    def resetting(self) -> bool:
        return self._resets.under_way()

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        clock = self._node.get_clock()
        found = {}
        for robot in self._cast if robots is None else robots:
            topic = self._topic(robot)
            if problem := topic.missing():
                found[robot] = f"{problem} ({self.description})"
            elif topic.is_stamped and clock.ros_time_is_active and not clock.now().nanoseconds:
                found[robot] = f"no time has come on /clock, so {topic.name} is stamped 0: start the simulation"
        return found

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        asked = self._cast if robots is None else robots
        found = {robot: line for robot, line in self._resets.warnings().items() if robot in asked}
        own = [node.get_fully_qualified_name() for node in self._nodes]
        clocked = not self._node.get_clock().ros_time_is_active and self._node.count_publishers("/clock")
        for robot in asked:
            topic = self._topic(robot)
            if others := [name for name in topic.others(own) if not _has_ended(name)]:
                found[robot] = (
                    f"somebody else also sends to {topic.name}: {', '.join(others)}; "
                    "robots obey both: stop one of them, or use twist_mux"
                )
            elif clocked and topic.is_stamped:
                found.setdefault(
                    robot,
                    f"{topic.name} is stamped with this machine's time, but somebody sends /clock: "
                    "if the robot is simulated, write `use_sim_time = true` under [ros] in improv.toml",
                )
        return found

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """Publish at once. What rclpy raises goes up: the stage then stops all robots. ValueError if no number."""
        if not all(map(math.isfinite, (twist.x, twist.y, twist.z, twist.yaw))):
            raise ValueError(f"{robot} was to move at a speed that is no finite number")
        profile = self._parts[robot].profile
        self._topic(robot).publish(twist.within(profile.max_linear, profile.max_angular), self._node.get_clock())

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Nothing: real robots stay where they are."""

    def advance(self, to: float) -> None:
        """Nothing: robots move by themselves."""

    def coasting(self) -> bool:
        return False

    def poses(self) -> dict[str, Pose]:
        return {}

    def close(self) -> None:
        import rclpy

        time.sleep(LINGER)
        self._closing.set()
        self._executor.shutdown()
        self._receiving.join()
        for node in self._nodes:
            node.destroy_node()
            rclpy.try_shutdown(context=node.context)

    def _receive(self) -> None:
        """On a thread of its own: the simulated time, answers of services, and what others ask of our parameters."""
        while not self._closing.wait(REST):
            self._executor.spin_once()

    def _topic(self, robot: str) -> Topic:
        return self._topics[self._parts[robot].topic]

    def _advertise(self, kind: Any, topic: str, second: bool) -> tuple[Any, Callable[[], None]]:
        try:
            from rclpy.event_handler import PublisherEventCallbacks
        except ImportError:  # Humble
            from rclpy.qos_event import PublisherEventCallbacks
        node = self._second_node() if second else self._node
        # The default ones keep a publisher in use while the executor waits, and its type on the topic too.
        none = PublisherEventCallbacks(use_default_callbacks=False)
        publisher = node.create_publisher(kind, topic, DEPTH, event_callbacks=none)
        return publisher, lambda: node.destroy_publisher(publisher)

    def _second_node(self) -> Any:
        """For topics that want both types: Fast DDS refuses them within one context.

        Made when it is needed, and not used for anything else: to be discovered takes it up to seconds.
        """
        if len(self._nodes) == 1:
            import rclpy

            # Nobody spins it, so it offers no services.
            name = f"{self._node.get_name()}_2"
            self._nodes.append(_node(rclpy.Context(), name, start_parameter_services=False))
        return self._nodes[1]

    def _use_sim_time(self, wanted: bool) -> None:
        if wanted != self._uses_sim_time:
            from rclpy.parameter import Parameter

            self._uses_sim_time = wanted
            self._node.set_parameters([Parameter("use_sim_time", value=wanted)])


def _node(context: Any, name: str, **options: bool) -> Any:
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    # rclpy's own handlers would invalidate the context before the last zero could be sent.
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    return rclpy.create_node(name, context=context, **options)


def _node_name(process: int | str = "") -> str:
    """Told apart from those of other servers on this machine and of other machines."""
    return f"improv_{re.sub('[^A-Za-z0-9_]', '_', socket.gethostname())}_{process or os.getpid()}"


def _has_ended(node: str) -> bool:
    """Whether it was the node of a stage here that was killed: the graph goes on to show it for some twenty seconds."""
    found = re.fullmatch(f"/{_node_name(process='([0-9]+)')}(?:_2)?", node)
    if not found or os.name != "posix":
        return False
    try:
        os.kill(int(found[1]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:
        pass  # somebody else's, and alive
    return False
