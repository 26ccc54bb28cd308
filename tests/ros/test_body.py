"""`improv body --topic`: the URDF that ROS 2 publishes. tests/robots/test_urdf.py tests how it is read."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.robots.test_urdf import ARMS, DOLL
from tests.ros.conftest import LIMIT, Publish, with_limits


@pytest.mark.slow("starts two ROS nodes one after the other")
def test_a_body_is_read_from_the_topic_that_has_its_description(
    ros_env: dict[str, str], publish: Publish, tmp_path: Path
) -> None:
    def body(topic: str, **limits: float) -> tuple[str, str]:
        command = [sys.executable, "-m", "improv_core", "body", "--topic", topic]
        env = ros_env | with_limits(**limits)
        done = subprocess.run(command, env=env, cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT)
        return done.stdout, done.stderr

    publish("/robot_description", "std_msgs/String", latched=True)({"data": DOLL}, once=True)
    text, problem = body("/robot_description", outputs__ros__graph__LOOK=20.0)
    assert text.startswith(ARMS.replace("doll.urdf", "/robot_description")), problem
    assert body("/nothing") == (
        "",
        "improv: nobody publishes text on /nothing: start robot_state_publisher, or name another topic\n",
    )
