"""ROS 2 keeps what `improv output check` asks of every output."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping

import pytest

from tests.ros.conftest import with_limits


@pytest.mark.slow("starts four stages")
def test_ros_keeps_what_outputs_promise(alone: Mapping[str, str]) -> None:
    command = [sys.executable, "-m", "improv_core", "output", "check", "ros", "--limit", "60"]
    env = {**alone, **with_limits(player__decide__LATE=0.6)}  # a stage that continues after 0.7 s has to be late
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.count(" yes ")) == (0, 7), done.stdout + done.stderr
