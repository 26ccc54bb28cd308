"""The time of a simulation, from /clock (rosgraph_msgs imported lazily)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from improv_core.outputs.ros.nodes import subscribe
from improv_core.outputs.ros.topic import Now
from improv_core.score.peer_clock import Anchor, Estimate, first_seen, sighted

FROZEN = 0.5
"""Seconds without another time on /clock from which the simulation counts as paused, before robots count as stuck."""
CLOCK = "/clock"
OFTEN = 0.05
"""The least number of seconds between two anchors: /clock may arrive a thousand times a second."""


class NodeTime:
    """The time of a node: the system's, or that on /clock."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._clock = node.get_clock()
        self._is_simulated = False
        self._latest = (0, math.inf)  # the time on /clock, and since when

    def simulate(self, wanted: bool) -> None:
        """Have the node read the time from /clock, or no longer."""
        if wanted != self._is_simulated:
            from rclpy.parameter import Parameter

            self._is_simulated = wanted
            self._node.set_parameters([Parameter("use_sim_time", value=wanted)])

    def is_frozen(self, now: float) -> bool:
        """Return whether it has stood for a while, at a monotonic time; false if nothing has come on /clock."""
        if not self._clock.ros_time_is_active or not (time := self._clock.now().nanoseconds):
            return False
        if time != self._latest[0]:
            self._latest = time, now
        return now >= self._latest[1] + FROZEN


class ClockListener:
    """Subscribes to /clock while a score follows it, and passes on anchors, on the thread of the node's executor.

    A message with the same time as the one before means that the simulation pauses; it is ignored.
    """

    def __init__(self, node: Any, hear: Callable[[Anchor], None], now: Now) -> None:
        self._node = node
        self._hear = hear
        self._now = now
        self._subscription: Any = None
        self._known: Estimate | None = None
        self._latest = -1.0  # the time in the latest message
        self._passed_on = 0.0  # when the latest anchor was passed on

    def follow(self, wanted: bool) -> None:
        """Subscribe to /clock, or unsubscribe."""
        if wanted and not self._subscription:
            from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
            from rosgraph_msgs.msg import Clock

            self._known = None
            # Only the latest message counts, and a simulator may publish best effort, as in rclpy.
            qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT, durability=DurabilityPolicy.VOLATILE)
            self._subscription = subscribe(self._node, Clock, CLOCK, self._take, qos)
        elif not wanted and self._subscription:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _take(self, message: Any) -> None:
        now, time = self._now(), message.clock.sec + message.clock.nanosec / 1e9
        if time == self._latest:
            return
        self._latest = time
        self._known = sighted(self._known, now, time) if self._known else first_seen(now, time)
        if self._known.is_known and now - self._passed_on >= OFTEN and self._known.anchor.at == now:
            self._passed_on = now
            self._hear(self._known.anchor)
