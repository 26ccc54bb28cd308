"""Who looks at ROS 2's graph leaves it, also where looking fails."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping

from improv_core.stage.protocol import FOLDER
from tests.ros.conftest import LIMIT

WITNESS = f"""
import subprocess, sys, time
import rclpy
rclpy.init()
node = rclpy.create_node("witness")
command = [sys.executable, {str(FOLDER / "graph.py")!r}, "look", "no topic!"]
looking = subprocess.Popen(command, stderr=subprocess.DEVNULL)
def until(fits, limit):
    end = time.monotonic() + limit
    while not fits() and time.monotonic() < end:
        time.sleep(0.01)
    return fits()
came = until(lambda: "improv_look" in node.get_node_names(), {LIMIT})
code = looking.wait()
# Well before the lease of a node that says nothing is over, after 20 s.
left = until(lambda: "improv_look" not in node.get_node_names(), 10)
print(came, code, left)
"""


def test_one_who_fails_to_look_leaves_the_graph(ros_python: str, ros_env: Mapping[str, str]) -> None:
    done = subprocess.run([ros_python, "-c", WITNESS], env=ros_env, capture_output=True, text=True, timeout=LIMIT * 2)
    assert done.stdout == "True 1 True\n", done.stderr
