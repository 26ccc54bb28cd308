"""A subscriber to robots' topics, run by ROS's interpreter: it keeps every Twist and its time until its input ends.

`spin TOPIC...` receives as a robot's driver does, each message in a callback of rclpy. `drain TOPIC...` lets the
middleware note the time of a message and takes it later, so that a thousand robots cost it little. Both write
`RECORD`s.
"""

from __future__ import annotations

import gc
import json
import platform
import struct
import sys
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from geometry_msgs.msg import Twist
from rclpy.qos import QoSProfile

RECORD = struct.Struct("<II7d")
"""The topic, the publisher's number for the message, the times at which it was published, received by the middleware
and heard (seconds of the monotonic clock; drained messages are not heard), x, y, z, yaw."""
DEPTH = 200
"""Messages kept until they are taken: ten seconds of a robot."""
DRAIN_PERIOD = 0.1
_VELOCITY = struct.Struct("<6d")

Taken = tuple[int, float, bytes, dict[str, Any]]


def main() -> None:
    """Listen; print `ready` with versions as one JSON line, then records as bytes."""
    way, *topics = sys.argv[1:]
    gc.disable()
    offset = _offset()
    rclpy.init()
    node = rclpy.create_node("benchmark_listener")
    ended = threading.Event()
    taken: list[Taken] = []
    listen = {"spin": _spin, "drain": _drain}[way](node, topics, taken)
    versions = {"rmw": rclpy.get_rmw_implementation_identifier(), "python": platform.python_version()}
    print(json.dumps(versions), flush=True)
    threading.Thread(target=_wait, args=(ended,), daemon=True).start()
    while not ended.is_set():
        listen(ended)
    if abs(_offset() - offset) > 100_000:
        raise RuntimeError("the machine's time was set in between")
    sys.stdout.buffer.write(b"".join(_record(each, offset) for each in taken))
    sys.stdout.buffer.flush()
    rclpy.try_shutdown()


def _spin(node: Any, topics: Sequence[str], taken: list[Taken]) -> Callable[[threading.Event], None]:
    def hear(place: int) -> Callable[[bytes, dict[str, Any]], None]:
        return lambda message, info: taken.append((place, time.monotonic(), message, info))

    for place, topic in enumerate(topics):
        node.create_subscription(Twist, topic, hear(place), QoSProfile(depth=DEPTH), raw=True)
    executor = rclpy.executors.SingleThreadedExecutor()
    executor.add_node(node)
    return lambda ended: executor.spin_once(timeout_sec=DRAIN_PERIOD)


def _drain(node: Any, topics: Sequence[str], taken: list[Taken]) -> Callable[[threading.Event], None]:
    quality = QoSProfile(depth=DEPTH)
    handles = [node.create_subscription(Twist, topic, lambda _: None, quality).handle for topic in topics]

    def drain(ended: threading.Event) -> None:
        ended.wait(DRAIN_PERIOD)
        for place, handle in enumerate(handles):
            while found := handle.take_message(Twist, True):
                taken.append((place, 0.0, *found))

    return drain


def _wait(ended: threading.Event) -> None:
    sys.stdin.read()
    ended.set()


def _record(taken: Taken, offset: int) -> bytes:
    place, heard, message, info = taken
    x, y, z, _, _, yaw = _VELOCITY.unpack_from(message, 4)  # after the four bytes that name the encoding of the rest
    published, received = ((info[f"{name}_timestamp"] - offset) / 1e9 for name in ("source", "received"))
    return RECORD.pack(place, info["publication_sequence_number"], published, received, heard, x, y, z, yaw)


def _offset() -> int:
    """Return the nanoseconds from the monotonic clock to the middleware's: of many tries, the one least disturbed."""
    looks = []
    for _ in range(1000):
        before = time.monotonic_ns()
        wall = time.time_ns()
        after = time.monotonic_ns()
        looks.append((after - before, wall - (before + after) // 2))
    return min(looks)[1]


if __name__ == "__main__":
    main()
