"""Somebody who presses buttons, run by ROS's interpreter: publishes what each line of its input says, until it ends.

`stop true` and `stop false` are for the emergency stop. `joy 1` and `joy 0` hold and release button 4 of a gamepad,
which is published 50 times a second until `joy silent`.
"""

import argparse
import sys
import threading

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool

parser = argparse.ArgumentParser()
parser.add_argument("--stop")
parser.add_argument("--latched", action="store_const", const=DurabilityPolicy.TRANSIENT_LOCAL, dest="durability")
parser.add_argument("--best-effort", action="store_const", const=ReliabilityPolicy.BEST_EFFORT, dest="reliability")
parser.add_argument("--joy")
options = parser.parse_args()
held = None


def publish_joy() -> None:
    if held is not None:
        joy.publish(Joy(buttons=[0, 0, 0, 0, held]))


rclpy.init()
node = rclpy.create_node("presser")
qos = QoSProfile(
    depth=1,
    durability=options.durability or DurabilityPolicy.VOLATILE,
    reliability=options.reliability or ReliabilityPolicy.RELIABLE,
)
if options.stop:
    stop = node.create_publisher(Bool, options.stop, qos)
if options.joy:
    joy = node.create_publisher(Joy, options.joy, 10)
    node.create_timer(0.02, publish_joy)
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
print(flush=True)
for line in sys.stdin:
    what, value = line.split()
    if what == "stop":
        stop.publish(Bool(data=value == "true"))
    else:
        held = None if value == "silent" else int(value)
rclpy.try_shutdown()
spinning.join()
