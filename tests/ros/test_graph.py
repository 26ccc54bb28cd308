"""A process that looks at ROS 2's graph leaves it, even if the look fails."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from improv_core.protocol.limits import FOLDER
from tests.ros.conftest import LIMIT, PROFILES, with_code

pytestmark = pytest.mark.slow("a look fails in its own process")

WITNESS = f"""
import subprocess, sys, time
import rclpy
rclpy.init()
node = rclpy.create_node("witness")
command = [sys.executable, {str(FOLDER)!r}, "graph", "look", "/topic"]
looking = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
def until(fits, limit):
    end = time.monotonic() + limit
    while not fits() and time.monotonic() < end:
        time.sleep(0.01)
    return fits()
came = until(lambda: "improv_look" in node.get_node_names(), {LIMIT})
looking.stdin.close()
code = looking.wait()
# Well before the lease of a node that says nothing is over, after 300 s here.
left = until(lambda: "improv_look" not in node.get_node_names(), {LIMIT})
print(came, code, left)
"""


BROKEN = """
import sys
try:
    from rclpy.node import Node
except ImportError:  # in another Python
    pass
else:
    def fail(self, topic):
        sys.stdin.read()
        raise RuntimeError(topic)

    Node.get_subscriptions_info_by_topic = fail
"""
"""Code that makes a look fail once it is in the graph."""


def test_a_failed_look_leaves_the_graph(ros_python: str, ros_env: Mapping[str, str], tmp_path: Path) -> None:
    lease, announced = "<leaseDuration><sec>300</sec></leaseDuration>", "<leaseAnnouncement>"
    profiles = tmp_path / "profiles.xml"
    profiles.write_text(Path(ros_env[PROFILES]).read_text().replace(announced, lease + announced))
    env = {**ros_env, PROFILES: str(profiles), **with_code(BROKEN)}
    done = subprocess.run([ros_python, "-c", WITNESS], env=env, capture_output=True, text=True, timeout=LIMIT * 2)
    assert done.stdout == "True 1 True\n", done.stderr
