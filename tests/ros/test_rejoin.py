"""A base that restarts in the middle of a dance, over ROS: the time and the place at which it joins again."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.processes import lines_until
from tests.ros.conftest import BASE, LIMIT, Listen, Script, with_limits
from tests.ros.dance import moving

pytestmark = pytest.mark.slow("a base is restarted, and drives on")

TOML = """
[ros]
odom_frame = "world"
rejoin = "return"
[world]
keep_apart = 0.1
[profiles.base]
base = "turtlebot4"
max_linear = 1
max_angular = 5
[robots.ada]
profile = "base"
odom = "true_pose"
start = { x = 0, y = 0, heading = 0 }
[robots.bo]
profile = "base"
odom = "true_pose"
start = { x = 0, y = 1, heading = 0 }
"""
GONE = "ada is gone, nothing listens on /ada/cmd_vel"
IDEAL = "--noise", "0", "--loss", "0"


def where(base: subprocess.Popen[str]) -> tuple[float, float, float]:
    """End a base, and return its pose."""
    x, y, heading = map(float, base.communicate()[0].split())
    return x, y, heading


def test_a_base_that_is_restarted_drives_to_where_its_part_has_it_by_then(
    script: Script, listen: Listen, ros_env: dict[str, str], tmp_path: Path
) -> None:
    """In tests/player, test_player.py and test_returning.py test other ways to join again, and the drive back."""
    listener = listen("/bo/cmd_vel")
    (tmp_path / "improv.toml").write_text(TOML)
    (tmp_path / "dance.improv").write_text("beat 60\nada bo $ repeat 5 forward repeat 14 rest repeat 2 backward\n")
    bases = {"ada": script(BASE, "ada", *IDEAL), "bo": script(BASE, "bo", *IDEAL, "--start", "0", "1", "0")}
    command = [sys.executable, "-m", "improv_core", "play", "--backend", "ros", "--force", "dance.improv"]
    env = ros_env | with_limits(player__subscribers__PATIENCE=LIMIT)  # ada, too, is found before beat 0
    with subprocess.Popen(
        command, cwd=tmp_path, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    ) as playing:
        listener.wait(moving)
        x, y, heading = where(bases["ada"])
        lines_until(GONE, playing.stderr)
        again = script(BASE, "ada", *IDEAL, "--start", str(x), str(y), str(heading))
        lines_until("ada is back in its place", playing.stderr)
        assert playing.stderr
        rest = playing.stderr.read()
        assert playing.wait() == 0, rest
    # A base moves 0.2 m in a second that a busy machine adds or takes.
    assert where(again)[0] == pytest.approx(0.6, abs=0.25)
