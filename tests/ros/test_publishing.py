"""Messages about a dance to other nodes in ROS 2, from a save to their subscriptions."""

from __future__ import annotations

import json
import os
import re
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.processes import command_of, descendants
from tests.ros.conftest import BASE, Fields, Listen, Script
from tests.ros.dance import Server

pytestmark = pytest.mark.slow("waits for what is published once a second")

CAST = """
[ros]
publish = true

[robots.anna]
start = { x = 1, y = 2, heading = 90 }
odom = "odom"

[robots.bert]

[profiles.slow]
step = 1
max_linear = 0.5

[robots.carl]
profile = "slow"
"""
PROGRAM = "anna $ repeat (forward left)\nbert $ repeat left\ncarl $ repeat forward\n"
DEAF = "nothing is listening on /bert/cmd_vel"
WARNING = 30
"""A level of rcl_interfaces/Log."""
WARN, FAILED = 1, 2
"""Levels of diagnostic_msgs/DiagnosticStatus."""


def statuses(message: Fields) -> dict[str, Fields]:
    return {each["name"].removeprefix("improv: "): each for each in message["status"]}


def all_known(message: Fields) -> bool:
    """Return whether diagnostics say that nobody listens to bert and that carl is too slow. On a busy machine, anna may
    be off its path."""
    found = statuses(message)
    return [found[name]["level"] for name in ("bert", "carl") if name in found] == [FAILED, WARN]


def seconds(message: Fields) -> float:
    stamp = message["header"]["stamp"]
    return float(stamp["sec"] + stamp["nanosec"] / 1e9)


def test_a_stage_publishes_its_paths_and_messages(
    script: Script, listen: Listen, alone: Mapping[str, str], tmp_path: Path
) -> None:
    """A second process publishes them after the first has failed, and none does once the file no longer asks for it. A
    process that hangs then ends with the stage."""
    script(BASE, "anna", "--loss", "0", "--noise", "0", **alone)
    listen("/carl/cmd_vel")
    transport = listen("/improv/transport", type="std_msgs/String")
    paths = listen("/improv/anna/path", type="nav_msgs/Path")
    markers = listen("/improv/markers", type="visualization_msgs/MarkerArray")
    diagnostics = listen("/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    lines = listen("/rosout", type="rcl_interfaces/Log", latched=True)
    (toml := tmp_path / "improv.toml").write_text(CAST)
    editor = Server(alone, uri=(tmp_path / "dance.improv").as_uri())

    def plays(since: int = 0) -> dict[str, Any]:
        """Wait for the position in a score after this one."""
        position: dict[str, Any] = {"state": "", "generation": 0}
        while position["state"] != "playing" or position["generation"] <= since:
            position = json.loads(transport.wait(lambda message: True)["data"])
        return position

    def publisher() -> int:
        (pid,) = [pid for pid in descendants(editor.pid) if b"\0outputs.ros.publisher.process\0" in command_of(pid)]
        return pid

    with editor.client:  # its standby tries for a while to stop bert, who has no listener
        editor.save(PROGRAM)
        path = paths.wait(lambda path: path["poses"] and path["header"]["frame_id"] == "odom")
        assert {each["header"]["frame_id"] for each in path["poses"]} == {"odom"}
        assert seconds(path["poses"][-1]) - seconds(path) == pytest.approx(30, abs=0.001)
        words = re.compile(r"anna\nbeat .*\n(forward|left)")
        seen = markers.wait(lambda seen: any(words.fullmatch(each["text"]) for each in seen["markers"]))
        assert all(each["header"]["stamp"]["sec"] == 0 for each in seen["markers"]), "rviz waits for no transforms"
        assert all(each["lifetime"]["sec"] > 1 for each in seen["markers"]), "labels vanish without their publisher"
        position = plays()
        assert (position["tempo"], position["beats"], position["muted"]) == (60, None, [])
        known = statuses(diagnostics.wait(all_known))
        assert known["bert"]["message"].startswith(DEAF)
        assert {"key": "within its limits", "value": "no"} in known["carl"]["values"]
        line = lines.wait(lambda line: line["name"].endswith("_publisher") and line["msg"].startswith(DEAF))
        assert line["level"] == WARNING

        toml.write_text(CAST.replace("true", "false"))
        editor.save(PROGRAM)
        transport.wait_for_publishers(lambda count: count == 0)
        toml.write_text(CAST)
        for fault in (signal.SIGKILL, signal.SIGSTOP):
            editor.save(PROGRAM)
            position = plays(position["generation"])
            os.kill(publisher(), fault)
            if fault == signal.SIGKILL:
                editor.wait_for_line(
                    "the process that publishes the dance has ended: it was killed: the next play starts another"
                )
        toml.write_text(CAST.replace("true", "false"))
        editor.save(PROGRAM)
