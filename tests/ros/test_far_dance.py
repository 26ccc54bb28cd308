"""A dance of a robot here and one on another machine, as a person plays it: through a real ssh server."""

from __future__ import annotations

import os
import shlex
import shutil
import signal
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.commands.command_line import IMPROV
from tests.processes import descendants, wait_until_gone
from tests.remote.sshd import a_host
from tests.ros.conftest import LIMIT, Listen
from tests.ros.test_link import set_there

TOML = """\
[robots.turtle1]
profile = "turtlesim"
[robots.turtle2]
profile = "turtlesim"
host = "robot"
"""
pytestmark = pytest.mark.slow("a real ssh server, and two stages of ROS 2 that find their robots")


def test_robots_here_and_there_begin_together_and_stop_with_ctrl_c(
    tmp_path: Path, ros_env: Mapping[str, str], listen: Listen
) -> None:
    (tmp_path / "improv.toml").write_text(TOML)
    dance = tmp_path / "dance.improv"
    dance.write_text("turtle1 turtle2 $ repeat forward\n")
    here, there = listen("/turtle1/cmd_vel"), listen("/turtle2/cmd_vel")
    with a_host(tmp_path / "host", set_there(ros_env)) as host:
        ssh = tmp_path / "bin" / "ssh"
        ssh.parent.mkdir()
        ssh.write_text(f'#!/bin/sh\nexec {shutil.which("ssh")} -F {shlex.quote(str(host.config))} "$@"\n')
        ssh.chmod(0o755)
        env = {**ros_env, "XDG_CONFIG_HOME": host.env["XDG_CONFIG_HOME"], "IMPROV_HISTORY": "off"}
        env["PATH"] = f"{ssh.parent}:{os.environ['PATH']}"
        command = [*IMPROV, "play", "--backend", "ros", str(dance)]
        with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as playing:
            try:
                began = [each.wait(lambda heard: heard["x"] == 2)["at"] for each in (here, there)]
                ours = descendants(playing.pid)
            finally:
                playing.send_signal(signal.SIGINT)
            for each in (here, there):
                each.wait(lambda heard: heard["x"] == 0)
            said, _ = playing.communicate(timeout=LIMIT)
        wait_until_gone(ours, LIMIT)
    assert "on robot" in said
    assert abs(began[1] - began[0]) < 5  # on a busy machine
