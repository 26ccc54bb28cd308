"""A sensor, run by ROS's interpreter: `sensor.py TOPIC PACKAGE/TYPE` publishes what each line of its input says.

A line is the fields of a message as JSON, nested ones with dots. It is published 20 times a second until the next line,
or once if it has `"once": true`. `null` is silence.
"""

import json
import sys
import threading
from functools import reduce
from importlib import import_module
from typing import Any

import rclpy
from rclpy.qos import qos_profile_sensor_data

topic, kind = sys.argv[1:]
package, _, name = kind.partition("/")
Message = getattr(import_module(f"{package}.msg"), name)
latest: dict[str, Any] | None = None


def publish(fields: dict[str, Any]) -> None:
    message = Message()
    for path, value in fields.items():
        *outer, last = path.split(".")
        setattr(reduce(getattr, outer, message), last, value)
    publisher.publish(message)


def repeat() -> None:
    if latest is not None:
        publish(latest)


rclpy.init()
node = rclpy.create_node("sensor")
publisher = node.create_publisher(Message, topic, qos_profile_sensor_data)
node.create_timer(0.05, repeat)
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
print(flush=True)
for line in sys.stdin:
    fields = json.loads(line)
    once = bool(fields and fields.pop("once", False))
    latest = None if once else fields
    if once:
        publish(fields)
node.destroy_node()
rclpy.try_shutdown()
spinning.join()
