"""The stage's ROS sink alone, run by ROS's interpreter: notes when edges come, until its input ends.

`ros_edges.py ROBOT...` reads the sense `near` of each from /ROBOT/scan. Writes edges as JSON: robot, value, when the
reader saw it, and when it was here (monotonic clock).
"""

from __future__ import annotations

import gc
import json
import sys
import time
from fractions import Fraction
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2]))  # as the stage does: last, and not installed

from improv_core.ipc.arrivals import End
from improv_core.outputs.ros.output import Ros
from improv_core.protocol.output import Alarm, Edge, RawJoints, RawPoses
from improv_core.score.motion import Pose
from improv_core.score.peer_clock import Anchor
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part, Score
from improv_core.score.senses import Topic

came: list[tuple[str, bool | None, float, float]] = []


def hear(edge: Edge | RawPoses | RawJoints | Alarm | Anchor | End) -> None:
    assert isinstance(edge, Edge)
    came.append((edge.what[0], edge.value, edge.at, time.monotonic()))


def part(robot: str) -> Part:
    near = Topic(f"/{robot}/scan", "sensor_msgs/LaserScan", below=0.5, start=-0.52, end=0.52)
    return Part(robot, (), TURTLESIM, Pose(), f"/{robot}/cmd_vel", senses={"near": near})


gc.freeze()
gc.set_threshold(50_000, 20, 100)
sink = Ros(None, False, hear, lambda request: None)
sink.prepare(Score(Fraction(60), {robot: part(robot) for robot in sys.argv[1:]}), True)
sys.stdin.read()
print(json.dumps(came), flush=True)
sink.close()
