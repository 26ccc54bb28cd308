"""A base that is restarted in the middle of a dance: when and where it joins again, over ROS."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.ros.conftest import BASE, LIMIT, Listen, Script, with_limits
from tests.ros.dance import still

pytestmark = pytest.mark.slow("a base is restarted, and drives on")

TOML = """
[ros]
odom_frame = "world"
rejoin = "{rejoin}"
[world]
keep_apart = 0.1
[profiles.base]
base = "turtlebot4"
max_linear = 1
max_angular = 5
[robots.ada]
profile = "base"
odom = "true_pose"
start = {{ x = 0, y = 0, heading = 0 }}
[robots.bo]
profile = "base"
odom = "true_pose"
start = {{ x = 0, y = 1, heading = 0 }}
"""
GONE = "ada is gone, nothing listens on /ada/cmd_vel"
IDEAL = "--noise", "0", "--loss", "0"


def where(base: subprocess.Popen[str]) -> tuple[float, float, float]:
    """End a base; where it is."""
    x, y, heading = map(float, base.communicate()[0].split())
    return x, y, heading


def until(playing: subprocess.Popen[str], part: str) -> str:
    assert playing.stderr
    said = []
    for line in playing.stderr:
        said.append(line)
        if part in line:
            return line
    raise AssertionError(f"it ended without {part!r}: {said}")


@pytest.mark.parametrize(
    ("rejoin", "program", "back"),
    [
        ("scene", "beat 60\nada bo $ repeat 12 forward\n---\nada bo $ backward rest\n", "until the next scene"),
        ("return", "beat 60\nada bo $ repeat 5 forward repeat 14 rest backward\n", "ada is back in its place"),
    ],
    ids=["scene", "return"],
)
def test_a_base_that_is_restarted_joins_again(
    rejoin: str, program: str, back: str, script: Script, listen: Listen, ros_env: dict[str, str], tmp_path: Path
) -> None:
    """At the next scene from where it stands, or where its part has it by then."""
    listener = listen("/bo/cmd_vel")
    (tmp_path / "improv.toml").write_text(TOML.format(rejoin=rejoin))
    (tmp_path / "dance.improv").write_text(program)
    bases = {"ada": script(BASE, "ada", *IDEAL), "bo": script(BASE, "bo", *IDEAL, "--start", "0", "1", "0")}
    command = [sys.executable, "-m", "improv_core", "play", "--backend", "ros", "--force", "dance.improv"]
    env = ros_env | with_limits(stage__listeners__PATIENCE=LIMIT)  # ada, too, is found before beat 0
    with subprocess.Popen(
        command, cwd=tmp_path, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as playing:
        listener.wait(lambda message: not still(message))
        x, y, heading = where(bases["ada"])
        until(playing, GONE)
        again = script(BASE, "ada", *IDEAL, "--start", str(x), str(y), str(heading))
        until(playing, back)
        assert playing.stderr
        rest = playing.stderr.read()
        assert playing.wait() == 0, rest
    began = x if rejoin == "scene" else 1.0
    assert where(again)[0] == pytest.approx(began - 0.2, abs=0.1)
