"""The recording of a real run on ROS 2, compared with the messages of a real subscriber."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Mapping
from itertools import dropwhile
from pathlib import Path

import pytest

from tests.commands.command_line import IMPROV
from tests.recordings import read, topics
from tests.ros.conftest import LIMIT, STAMPED, Listen, Publish, with_limits
from tests.ros.dance import moving, still

pytestmark = pytest.mark.slow("starts what plays and records")

TOPIC = "/base/cmd_vel"
CLOCKS = 0.01
"""Seconds by which two readings of clocks may differ."""


def test_a_recording_is_what_a_subscriber_heard(
    listen: Listen, publish: Publish, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """The robot takes stamps, has limits, and has other topics by ROS's arguments. Messages are recorded no later than
    they are heard. Its poses are recorded where no robot takes them for its own."""
    toml = '[robots.turtle1]\nprofile = "turtlebot3_burger"\nodom = "odom"\n'
    (tmp_path / "improv.toml").write_text(toml)
    source, path = tmp_path / "dance.improv", tmp_path / "dance.mcap"
    source.write_text("beat 90\nturtle1 $ (fast 3 forward [left right left]) || slow 5/2 left\n")
    listener = listen(TOPIC, type=STAMPED)
    publish("/base/odom", "nav_msgs/Odometry")({"header.frame_id": "odom", "pose.pose.orientation.w": 1.0})
    remaps = [word for name in ("cmd_vel", "odom") for word in ("-r", f"/turtle1/{name}:=/base/{name}")]
    command = [*IMPROV, "record", "--backend", "ros", str(source), "-o", str(path), "--ros-args", *remaps]
    env = {**ros_env, **with_limits(player__subscribers__PATIENCE=LIMIT)}
    done = subprocess.run(command, env=env, stdout=subprocess.PIPE, text=True, timeout=2 * LIMIT, check=True)
    listener.wait(moving)
    for _ in range(3):  # the zeros that end every motion
        listener.wait(still)
    recorded, heard = read(path), [*dropwhile(still, listener.heard)]
    assert [message.velocity for message in recorded] == [(m["x"], m["y"], m["z"], m["yaw"]) for m in heard]
    wall = time.time() - time.monotonic()
    for message, then in zip(recorded, heard, strict=True):
        assert message.time / 1e9 < then["at"] + wall + CLOCKS
    assert done.stdout.splitlines()[-1].startswith(f"{path}: 1 robot, {len(recorded)} messages, ")
    assert max(message.velocity[0] for message in recorded) == pytest.approx(0.22)
    assert {topic: found.msgtype for topic, found in topics(path).items()} == {
        TOPIC: "geometry_msgs/msg/TwistStamped",
        "/improv/turtle1/pose": "geometry_msgs/msg/PoseStamped",
    }
