"""`improv doctor` with ROS 2: it sees who is there, and tells no robot anything.

What it makes of what it sees is asked in tests/commands/test_doctor.py.
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
"""


def doctor(env: Mapping[str, str], folder: Path, *arguments: str) -> tuple[int, list[str]]:
    command = [sys.executable, "-m", "improv_core", "doctor", *arguments]
    done = subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True, encoding="utf-8", timeout=LIMIT)
    assert done.stderr == ""
    return done.returncode, done.stdout.splitlines()


@pytest.mark.parametrize(
    ("ahead", "says"),
    [
        (0, r"✓ r: poses on /r/true_pose, 0\.\d\d s old by their stamps"),
        (60, r"✗ r: the clock that stamps /r/true_pose is at least (60\.0|59\.)\d+ s ahead of this machine's: .*"),
        (-60, r"✗ r: poses on /r/true_pose are 6\d\.\d\d s old by their stamps: .*"),
    ],
)
def test_the_doctor_compares_the_clock_of_a_base_with_ours(
    ahead: int, says: str, ros_env: dict[str, str], script: Script, tmp_path: Path
) -> None:
    script(BASE, "r", "--ahead", str(ahead))
    (tmp_path / "improv.toml").write_text('[robots.r]\nodom = "true_pose"\n')
    end, found = time.monotonic() + LIMIT, list[str]()
    while not found and time.monotonic() < end:  # on a busy machine, discovery may take longer than it looks
        _, lines = doctor(ros_env, tmp_path)
        found = [line for line in lines if "/r/true_pose" in line and line.startswith(("✓", "✗"))]
    (line,) = found
    assert re.fullmatch(says, line)


def test_the_doctor_names_a_robot_that_is_not_in_its_place(
    ros_env: dict[str, str], script: Script, tmp_path: Path
) -> None:
    script(BASE, "r", "--start", "0.36", "0", "0")
    toml = '[robots.r]\nodom = "true_pose"\nodom_frame = "world"\nstart = { x = 0, y = 0, heading = 0 }\n'
    (tmp_path / "improv.toml").write_text(toml)
    end, lines = time.monotonic() + LIMIT, list[str]()
    while not any("its place" in line for line in lines) and time.monotonic() < end:  # as above
        _, lines = doctor(ros_env, tmp_path)
    assert "– r is not in its place: move r 0.36 m toward 180°" in lines


def test_the_doctor_sees_which_nodes_are_there(
    ros_env: dict[str, str], ros_python: str, listen: Listen, publish: Publish, tmp_path: Path
) -> None:
    listener = listen("/lab/anna")
    listen("/lab/carl", type=STAMPED)
    publish("/lab/anna", "geometry_msgs/Twist", name="teleop")
    (tmp_path / "improv.toml").write_text(TOML)
    expected = [
        "✓ anna: /listener listens for Twist on /lab/anna",
        "– anna: /teleop also publishes on /lab/anna: stop it while Improv plays, or the robot obeys both and stutters",
        "– bert: nothing is listening on /lab/bert: start the robot",
        "✗ carl: /twiststamped listens for TwistStamped on /lab/carl, not Twist: "
        'set `message = "auto"` for it in improv.toml',
    ]
    end = time.monotonic() + LIMIT
    while True:  # on a busy machine, discovery may take longer than it looks
        code, lines = doctor({**ros_env, **with_code(NOISE)}, tmp_path)
        seen = [line for line in lines if line[2:6] in ("anna", "bert", "carl")]
        if seen == expected or time.monotonic() > end:
            break
    assert seen == expected
    assert code == 1
    assert f"from IMPROV_ROS_PYTHON: {ros_python}" in "\n".join(lines)
    domain = ros_env["ROS_DOMAIN_ID"]
    assert any(line.startswith(f"✓ domain {domain}, this machine only: ") for line in lines)
    assert "✓ the standby, which stops robots if the process that moves them dies" in lines
    assert listener.heard == []
