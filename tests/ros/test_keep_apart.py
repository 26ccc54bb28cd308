"""Two simulated bases that drive toward each other, with late poses, over ROS: their distance at rest."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.ros.conftest import BASE, LIMIT, Script, with_limits
from tests.ros.dance import Terminal

pytestmark = pytest.mark.slow("two bases drive toward each other")

TOML = """
[ros]
odom_frame = "world"
[world]
keep_apart = 0.1
[profiles.base]
base = "create3"
step = 0.3
[robots.ada]
profile = "base"
odom = "true_pose"
start = { x = 0, y = 0, heading = 0 }
[robots.bo]
profile = "base"
odom = "true_pose"
start = { x = 2, y = 0, heading = 180 }
"""
RADIUS = 0.164
ARGUMENTS = "--noise", "0", "--loss", "0", "--delay", "0.08", "--rests"


def test_bases_that_drive_toward_each_other_come_to_rest_apart(
    script: Script, ros_env: dict[str, str], tmp_path: Path
) -> None:
    """At 0.3 m/s, braking at 0.9 m/s². tests/safety/test_keep_apart.py has all other cases."""
    (tmp_path / "improv.toml").write_text(TOML)
    bases = [script(BASE, "ada", *ARGUMENTS), script(BASE, "bo", *ARGUMENTS, "--start", "2", "0", str(math.pi))]
    env = ros_env | with_limits(player__subscribers__PATIENCE=LIMIT)
    with Terminal("play", tmp_path / "dance.improv", env, "beat 60\nada bo $ repeat forward\n") as playing:
        playing.wait_for_line("paused: ada and bo are ")
        (one, *_), (other, *_) = (map(float, base.communicate(timeout=LIMIT)[0].split()) for base in bases)
    assert 0.1 <= other - one - 2 * RADIUS < 0.35
