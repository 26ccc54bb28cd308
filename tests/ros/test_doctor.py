"""Commands that look at ROS 2: they see the nodes that run, and send robots nothing.

tests/commands/test_doctor.py tests the conclusions of `improv doctor`, tests/robots/test_urdf.py how a body is read.
"""

from __future__ import annotations

import re
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.commands.command_line import IMPROV
from tests.robots.test_urdf import DOLL, PARTS
from tests.ros.conftest import BASE, LIMIT, NOISE, STAMPED, Listen, Publish, Script, with_code, with_limits

pytestmark = pytest.mark.slow("looks for three seconds who is there")

TOML = """
[robots.anna]
topic = "/lab/anna"
[robots.bert]
topic = "/lab/bert"
[robots.carl]
topic = "/lab/carl"
message = "Twist"
[robots.dora]
odom = "true_pose"
odom_frame = "world"
start = { x = 0, y = 0, heading = 0 }
[robots.emil]
odom = "amcl_pose"
"""


def improv(env: Mapping[str, str], folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*IMPROV, *arguments], env=env, cwd=folder, capture_output=True, text=True, encoding="utf-8", timeout=LIMIT
    )


def test_a_body_is_read_from_the_topic_that_has_its_description(
    ros_env: dict[str, str], publish: Publish, tmp_path: Path
) -> None:
    publish("/robot_description", "std_msgs/String", latched=True)({"data": DOLL}, once=True)
    patient = ros_env | with_limits(outputs__ros__graph__LOOK=20.0)
    read = improv(patient, tmp_path, "body", "--topic", "/robot_description")
    assert read.stdout.startswith(PARTS.replace("doll.urdf", "/robot_description")), read.stderr
    unread = improv(ros_env, tmp_path, "body", "--topic", "/nothing")
    line = "nobody publishes text on /nothing: start robot_state_publisher, or name another topic"
    assert (unread.stdout, unread.stderr) == ("", f"improv: {line}\n")


def test_the_doctor_reports_listeners_other_publishers_places_and_clocks(
    ros_env: dict[str, str], ros_python: str, script: Script, listen: Listen, publish: Publish, tmp_path: Path
) -> None:
    listener = listen("/lab/anna")
    listen("/lab/carl", type=STAMPED)
    publish("/lab/anna", "geometry_msgs/Twist", name="teleop")
    script(BASE, "dora", "--start", "0.36", "0", "0", "--ahead", "60")
    listen("/emil/cmd_vel")
    amcl = publish("/emil/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped", latched=True, name="amcl")
    then = {"header.stamp.sec": int(time.time()) - 3600, "pose.pose.orientation.w": 1.0}
    amcl(then, once=True)
    (tmp_path / "improv.toml").write_text(TOML)
    expected = [
        "✓ anna: /listener listens for Twist on /lab/anna",
        "– anna: /teleop also publishes on /lab/anna: stop it while Improv plays, or the robot obeys both and stutters",
        "– bert: nothing is listening on /lab/bert: start the robot",
        "✗ carl: /twiststamped listens for TwistStamped on /lab/carl, not Twist: "
        'set `message = "auto"` for it in improv.toml',
        "✓ dora: /dora_base listens for Twist on /dora/cmd_vel",
        "✓ emil: /listener listens for Twist on /emil/cmd_vel",
        "✗ dora: the clock that stamps /dora/true_pose is at least 60 s ahead of this machine's: "
        "synchronize both, such as with chrony",
        "✓ emil: the latest pose on /emil/amcl_pose is 3600 s old; the next one follows a movement",
        "– dora is not in its place: move dora 0.36 m toward 180°",
    ]
    end = time.monotonic() + LIMIT
    while True:  # on a busy machine, discovery may take longer than it looks
        done = improv({**ros_env, **with_code(NOISE)}, tmp_path, "doctor")
        assert done.stderr == ""
        lines = done.stdout.splitlines()
        seen = [
            re.sub(r"36\d\d s", "3600 s", re.sub(r"(59|60)\.\d\d s", "60 s", line))
            for line in lines
            if line[2:6] in ("anna", "bert", "carl", "dora", "emil")
        ]
        if seen == expected or time.monotonic() > end:
            break
    assert seen == expected
    assert done.returncode == 1
    assert f"from IMPROV_ROS_PYTHON: {ros_python}" in "\n".join(lines)
    domain = ros_env["ROS_DOMAIN_ID"]
    assert any(line.startswith(f"✓ domain {domain}, this machine only: ") for line in lines)
    assert "✓ the standby, which stops robots if the process that moves them dies" in lines
    assert listener.heard == []
