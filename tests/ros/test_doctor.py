"""`improv doctor` with ROS 2: it sees the nodes that run, and sends robots nothing.

tests/commands/test_doctor.py tests its conclusions.
"""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.ros.conftest import BASE, LIMIT, NOISE, STAMPED, Listen, Publish, Script, with_code

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
"""


def doctor(env: Mapping[str, str], folder: Path, *arguments: str) -> tuple[int, list[str]]:
    command = [sys.executable, "-m", "improv_core", "doctor", *arguments]
    done = subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True, encoding="utf-8", timeout=LIMIT)
    assert done.stderr == ""
    return done.returncode, done.stdout.splitlines()


def test_the_doctor_reports_listeners_other_publishers_places_and_clocks(
    ros_env: dict[str, str], ros_python: str, script: Script, listen: Listen, publish: Publish, tmp_path: Path
) -> None:
    listener = listen("/lab/anna")
    listen("/lab/carl", type=STAMPED)
    publish("/lab/anna", "geometry_msgs/Twist", name="teleop")
    script(BASE, "dora", "--start", "0.36", "0", "0", "--ahead", "60")
    (tmp_path / "improv.toml").write_text(TOML)
    expected = [
        "✓ anna: /listener listens for Twist on /lab/anna",
        "– anna: /teleop also publishes on /lab/anna: stop it while Improv plays, or the robot obeys both and stutters",
        "– bert: nothing is listening on /lab/bert: start the robot",
        "✗ carl: /twiststamped listens for TwistStamped on /lab/carl, not Twist: "
        'set `message = "auto"` for it in improv.toml',
        "✓ dora: /dora_base listens for Twist on /dora/cmd_vel",
        "✗ dora: the clock that stamps /dora/true_pose is at least 60 s ahead of this machine's: "
        "synchronize both, such as with chrony",
        "– dora is not in its place: move dora 0.36 m toward 180°",
    ]
    end = time.monotonic() + LIMIT
    while True:  # on a busy machine, discovery may take longer than it looks
        code, lines = doctor({**ros_env, **with_code(NOISE)}, tmp_path)
        seen = [
            re.sub(r"(59|60)\.\d\d s", "60 s", line) for line in lines if line[2:6] in ("anna", "bert", "carl", "dora")
        ]
        if seen == expected or time.monotonic() > end:
            break
    assert seen == expected
    assert code == 1
    assert f"from IMPROV_ROS_PYTHON: {ros_python}" in "\n".join(lines)
    domain = ros_env["ROS_DOMAIN_ID"]
    assert any(line.startswith(f"✓ domain {domain}, this machine only: ") for line in lines)
    assert "✓ the standby, which stops robots if the process that moves them dies" in lines
    assert listener.heard == []
