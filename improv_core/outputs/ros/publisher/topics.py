"""The topics on which other ROS 2 programs can watch a dance (rclpy and messages imported lazily)."""

from __future__ import annotations

import colorsys
import json
import math
import re
import socket
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from typing import Any, NamedTuple

from improv_core.outputs.ros.clock import NodeTime
from improv_core.outputs.ros.nodes import Nodes
from improv_core.preview.forecast import Forecast
from improv_core.protocol.commands import is_muted
from improv_core.protocol.helper_messages import Health
from improv_core.protocol.messages import TransportMessage
from improv_core.protocol.transport import counted
from improv_core.safety.fault_rules import LATE
from improv_core.score.faults import Fault
from improv_core.score.motion import Pose

MARKER_LIFETIME = 3
"""Seconds until a marker vanishes without another: its robot has left, or its publisher has ended or was killed."""
TEXT_HEIGHT, ABOVE = 0.15, 0.4
"""Meters: the size of a marker's text, and its height above the robot."""
LONGEST_NAME = 200
"""The most characters of a robot's name in the name of a topic, which may have 247."""
SEVERE: Set[Fault] = {"gone", "silent", "stuck"}
"""The faults that are errors for monitors: the robot doesn't take part in the dance. Others are warnings."""
GOLDEN = 0.618
"""The share of the color circle between two robots, so that no two look alike."""

Advertised = tuple[Any, Callable[[], None]]
"""A publisher, and a function that destroys it."""


class Publications:
    """Publishes to all subscribers, with ROS's `arguments`. Raises ImportError without rclpy or its messages."""

    def __init__(self, node: str, arguments: Sequence[str]) -> None:
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.executors import SingleThreadedExecutor
        from std_msgs.msg import String
        from visualization_msgs.msg import MarkerArray

        self._nodes = Nodes(node, arguments, start_parameter_services=False)
        self._node = self._nodes.first
        self._executor: Any = SingleThreadedExecutor(context=self._node.context)
        self._executor.add_node(self._node)
        self._clock, self._time = self._node.get_clock(), NodeTime(self._node)
        self._markers = self._advertise(MarkerArray, "/improv/markers")
        self._transport = self._advertise(String, "/improv/transport")
        self._diagnostics = self._advertise(DiagnosticArray, "/diagnostics")
        self._paths: dict[str, Advertised] = {}

    def spin(self) -> None:
        """Read the time from /clock, if the node uses it."""
        self._executor.spin_once(timeout_sec=0)

    def log(self, severity: str, line: str) -> None:
        """Publish a line on /rosout."""
        logger = self._node.get_logger()
        if severity == "error":
            logger.error(line)
        else:
            logger.warning(line)

    def publish(self, forecast: Forecast, health: Health, now: float) -> None:
        score, transport = forecast.score, forecast.transport
        if not score or not transport:
            return
        self._time.simulate(any(part.use_sim_time for part in score.parts.values()))
        self._publish_paths(forecast)
        self.publish_markers(forecast, now)
        if is_heard(self._transport):
            from std_msgs.msg import String

            position = {"beat": forecast.beat(now), **{name: transport.get(name) for name in _POSITION}}
            self._transport[0].publish(String(data=json.dumps(position)))
        if is_heard(self._diagnostics):
            from diagnostic_msgs.msg import DiagnosticArray

            array = DiagnosticArray(status=[_status(each) for each in diagnose(forecast, health, now)])
            array.header.stamp = self._clock.now().to_msg()
            self._diagnostics[0].publish(array)

    def publish_markers(self, forecast: Forecast, now: float) -> None:
        """Publish the ideal poses of robots and the words that they play."""
        score = forecast.score
        if not score or not is_heard(self._markers):
            return
        from visualization_msgs.msg import Marker, MarkerArray

        markers = []
        for number, robot in enumerate(score.parts):
            current = forecast.robot(robot, now)
            marker = Marker(ns=robot, type=Marker.TEXT_VIEW_FACING, action=Marker.ADD)
            frame = forecast.frame(robot)
            # Stamped with the present time, it would be hidden until the frame's next transform.
            marker.header.frame_id, marker.frame_locked, marker.lifetime.sec = frame.name, True, MARKER_LIFETIME
            marker.text = f"{robot}\n{_position(forecast, now)}\n{' '.join(current.words)}"
            _place(marker.pose, current.pose or frame.origin.then(score.parts[robot].start), ABOVE)
            marker.scale.z = TEXT_HEIGHT
            marker.color.r, marker.color.g, marker.color.b = colorsys.hsv_to_rgb(number * GOLDEN % 1, 0.6, 1.0)
            marker.color.a = 1.0
            markers.append(marker)
        self._markers[0].publish(MarkerArray(markers=markers))

    def close(self) -> None:
        self._executor.shutdown()
        self._nodes.close()

    def _publish_paths(self, forecast: Forecast) -> None:
        from builtin_interfaces.msg import Time
        from geometry_msgs.msg import PoseStamped
        from nav_msgs.msg import Path

        assert forecast.score
        topics = path_topics(forecast.score.parts)
        for topic in self._paths.keys() - topics.values():
            self._paths.pop(topic)[1]()
        for robot, topic in topics.items():
            if topic not in self._paths:
                self._paths[topic] = self._advertise(Path, topic)
            if not is_heard(self._paths[topic]):
                continue
            now = self._clock.now()
            path, nanoseconds, frame = Path(), now.nanoseconds, forecast.frame(robot).name
            path.header.frame_id, path.header.stamp = frame, now.to_msg()
            for seconds, pose in forecast.path(robot):
                stamped = PoseStamped()
                stamped.header.frame_id = frame
                sec, nanosec = divmod(nanoseconds + round(seconds * 1e9), 1_000_000_000)
                stamped.header.stamp = Time(sec=sec, nanosec=nanosec)
                _place(stamped.pose, pose)
                path.poses.append(stamped)
            self._paths[topic][0].publish(path)

    def _advertise(self, kind: Any, topic: str) -> Advertised:
        return self._nodes.advertise(kind, topic, False)


_POSITION = ("state", "beats", "tempo", "speed", "generation", "muted", "soloed", "waits_for")
"""The fields of the transport that are published, besides the beat."""


class Diagnosis(NamedTuple):
    """A line for monitors. `level` is that of diagnostic_msgs/DiagnosticStatus: 0 is OK, 1 a warning, 2 an error."""

    name: str
    level: int
    message: str
    values: Mapping[str, str]
    hardware: str
    """The real robot, or the machine that runs Improv."""


def diagnose(forecast: Forecast, health: Health, now: float) -> Iterator[Diagnosis]:
    """Diagnoses of the performance and of each robot."""
    transport, score = forecast.transport, forecast.score
    if not transport or not score:
        return
    late = health["late"]
    values = {
        "beat": f"{forecast.beat(now):.2f}",
        "tempo": f"{transport['tempo']:g}",
        "late (ms)": f"{late * 1000:.1f}",
        "waits for": ", ".join(transport.get("waits_for", ())),
    }
    message = f"{transport['state']}, {late * 1000:.0f} ms late" if late > LATE else transport["state"]
    yield Diagnosis("improv", int(late > LATE), message, values, socket.gethostname())
    for robot, part in score.parts.items():
        missing, clipped = health["missing"].get(robot), robot in health["clipped"]
        faults = forecast.faults.get(robot, {})
        lines = [*([missing] if missing else []), *faults.values()]
        lines += ["its commands exceeded its limits and were scaled down"] if clipped else []
        level = 2 if missing or not SEVERE.isdisjoint(faults) else int(bool(lines))
        flags = {**_flags(robot, missing, clipped, transport), "faults": ", ".join(sorted(faults))}
        yield Diagnosis(f"improv: {robot}", level, "; ".join(lines) or "OK", flags, part.namespace)


def path_topics(robots: Sequence[str] | Mapping[str, Any]) -> dict[str, str]:
    """The topic of each robot's path. Names in programs may have letters that ROS 2 doesn't allow."""
    topics: dict[str, str] = {}
    for robot in robots:
        name = first = re.sub("[^A-Za-z0-9_]", "_", robot)[:LONGEST_NAME]
        number = 1
        while (topic := f"/improv/{name}/path") in topics.values() or (name != robot and name in robots):
            number += 1
            name = f"{first}_{number}"
        topics[robot] = topic
    return topics


def is_heard(advertised: Advertised) -> bool:
    return bool(advertised[0].get_subscription_count())


def _flags(robot: str, missing: str | None, clipped: bool, transport: TransportMessage) -> dict[str, str]:
    muted = is_muted(robot, transport["muted"], transport["soloed"])
    return {"listens": _yes(not missing), "within its limits": _yes(not clipped), "muted": _yes(muted)}


def _yes(flag: bool) -> str:
    return "yes" if flag else "no"


def _status(diagnosis: Diagnosis) -> Any:
    from diagnostic_msgs.msg import DiagnosticStatus, KeyValue

    values = [KeyValue(key=key, value=value) for key, value in diagnosis.values.items()]
    level = bytes([diagnosis.level])
    return DiagnosticStatus(
        level=level, name=diagnosis.name, message=diagnosis.message, hardware_id=diagnosis.hardware, values=values
    )


def _position(forecast: Forecast, now: float) -> str:
    assert forecast.transport
    state = forecast.transport["state"]
    beat = counted(forecast.transport, forecast.beat(now))
    return beat if state == "playing" else f"{beat}, {state}"


def _place(message: Any, pose: Pose, above: float = 0.0) -> None:
    """Write a pose into a geometry_msgs/Pose."""
    message.position.x, message.position.y, message.position.z = pose.x, pose.y, pose.z + above
    message.orientation.z, message.orientation.w = math.sin(pose.heading / 2), math.cos(pose.heading / 2)
