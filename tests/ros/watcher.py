"""A watcher of the dance, run by ROS's interpreter: it prints messages, one JSON line each, until its input ends.

Its arguments are topics of nav_msgs/Path.
"""

import json
import sys
import threading

import own_output  # noqa: F401, before any library may print
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Path
from rcl_interfaces.msg import Log
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

rclpy.init()
node = rclpy.create_node("watcher")
publishers = 0


def say(**values):
    print(json.dumps(values), flush=True)


def seconds(stamp):
    return stamp.sec + stamp.nanosec / 1e9


def path(topic, message):
    frames = sorted({message.header.frame_id, *(pose.header.frame_id for pose in message.poses)})
    begin = seconds(message.header.stamp)
    at = [seconds(pose.header.stamp) - begin for pose in message.poses]
    poses = [[pose.pose.position.x, pose.pose.position.y] for pose in message.poses]
    say(topic=topic, frames=frames, at=at, poses=poses)


def markers(message):
    say(topic="markers", texts=[marker.text for marker in message.markers if marker.action == marker.ADD])


def diagnostics(message):
    for status in message.status:
        values = {each.key: each.value for each in status.values}
        say(topic="diagnostics", name=status.name, level=ord(status.level), message=status.message, values=values)


def count_publishers():
    global publishers
    if publishers != (publishers := node.count_publishers("/improv/transport")):
        say(topic="publishers", count=publishers)


for topic in sys.argv[1:]:
    node.create_subscription(Path, topic, lambda message, topic=topic: path(topic, message), 10)
node.create_subscription(MarkerArray, "/improv/markers", markers, 10)
node.create_subscription(
    String, "/improv/transport", lambda message: say(topic="transport", **json.loads(message.data)), 10
)
node.create_subscription(DiagnosticArray, "/diagnostics", diagnostics, 10)
node.create_subscription(
    Log, "/rosout", lambda log: say(topic="rosout", name=log.name, level=log.level, text=log.msg), 10
)
node.create_timer(0.05, count_publishers)
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
say(topic="ready")
sys.stdin.read()
# A thread still inside rclpy when Python ends would abort the process.
rclpy.try_shutdown()
spinning.join()
