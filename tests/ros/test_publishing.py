"""Messages about a dance to other nodes in ROS 2, from a save to their subscriptions."""

from __future__ import annotations

import json
import math
import os
import re
import signal
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.processes import descendants
from tests.ros.conftest import BASE, Listen, Script
from tests.ros.dance import Server

pytestmark = pytest.mark.slow("waits for what is published once a second")

WATCHER = Path(__file__).with_name("watcher.py")
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
WARNING, ERROR = 30, 40
"""The levels of rcl_interfaces/Log."""

Seen = Mapping[str, Any]
Watch = Callable[[str, Callable[[Seen], bool]], Seen]


@pytest.fixture
def watch(script: Script, alone: Mapping[str, str]) -> Watch:
    """Wait for a message on a topic that fits, which may have come before."""
    stdout = script(WATCHER, "/improv/anna/path", **alone).stdout
    seen: list[Seen] = []

    def wait(topic: str, fits: Callable[[Seen], bool]) -> Seen:
        assert stdout
        while not (found := next((each for each in seen if each["topic"] == topic and fits(each)), None)):
            seen.append(json.loads(stdout.readline()))
            assert seen[-1].get("level") != ERROR, seen[-1]  # on a machine that is too busy, the stage stops its robots
        return found

    return wait


def named(name: str) -> Callable[[Seen], bool]:
    return lambda message: message["name"] == name


def command_of(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_text()


def test_a_stage_publishes_its_paths_and_messages(
    watch: Watch, script: Script, listen: Listen, alone: Mapping[str, str], tmp_path: Path
) -> None:
    """A second process publishes them after the first has failed, and none does once the file no longer asks for it. A
    process that hangs then ends with the stage."""
    script(BASE, "anna", "--loss", "0", "--noise", "0", **alone)
    listen("/carl/cmd_vel")
    toml = tmp_path / "improv.toml"
    toml.write_text(CAST)
    editor = Server(alone, uri=(tmp_path / "dance.improv").as_uri())
    with editor.client:  # its standby tries for a while to stop bert, who has no listener
        editor.save(PROGRAM)
        path = watch("/improv/anna/path", lambda path: path["poses"] and path["frames"] == ["odom"])
        assert path["at"][0] == 0
        assert path["at"][-1] == pytest.approx(30, abs=0.001)
        # A square of 2 m, turned and moved a little by late commands. Its odometry begins at 0, and the world's
        # start is elsewhere: there, the middle of the square is at (0, 3).
        lows, highs = ([function(each) for each in zip(*path["poses"], strict=True)] for function in (min, max))
        assert all(1.9 <= high - low <= 2.9 for low, high in zip(lows, highs, strict=True))
        middle = [(low + high) / 2 for low, high in zip(lows, highs, strict=True)]
        assert math.dist(middle, (1, 1)) < math.dist(middle, (0, 3))
        lit = watch("markers", lambda seen: any(re.match("anna\n.*\n.", text) for text in seen["texts"]))
        (text,) = [text for text in lit["texts"] if text.startswith("anna")]
        name, beat, word = text.split("\n")
        assert name == "anna"
        assert beat.startswith("beat ")
        assert word in ("forward", "left")
        position = watch("transport", lambda seen: seen["state"] == "playing")
        assert (position["tempo"], position["beats"], position["muted"]) == (60, None, [])
        whole = watch("diagnostics", named("improv"))
        assert float(whole["values"]["late (ms)"]) >= 0
        assert watch("diagnostics", named("improv: anna"))["message"] == "OK"
        missing = watch("diagnostics", lambda seen: seen["name"] == "improv: bert" and seen["level"] == 2)
        assert missing["message"].startswith("nothing is listening on /bert/cmd_vel")
        clipped = watch("diagnostics", lambda seen: seen["name"] == "improv: carl" and seen["level"] == 1)
        assert clipped["values"]["within its limits"] == "no"
        line = watch("rosout", lambda seen: seen["name"].endswith("_publisher"))
        assert line["text"].startswith("nothing is listening on /bert/cmd_vel")
        assert line["level"] == WARNING
        toml.write_text(CAST.replace("true", "false"))
        editor.save(PROGRAM)
        watch("publishers", lambda seen: seen["count"] == 0)
        toml.write_text(CAST)
        editor.save(PROGRAM)
        position = watch("transport", lambda seen: seen["generation"] > position["generation"])
        (publisher,) = [pid for pid in descendants(editor.pid) if "\0publisher\0" in command_of(pid)]
        os.kill(publisher, signal.SIGKILL)
        editor.wait_for_line(
            "the process that publishes the dance has ended: it was killed: the next play starts another"
        )
        editor.save(PROGRAM)
        position = watch("transport", lambda seen: seen["generation"] > position["generation"])
        (publisher,) = [pid for pid in descendants(editor.pid) if "\0publisher\0" in command_of(pid)]
        os.kill(publisher, signal.SIGSTOP)
        toml.write_text(CAST.replace("true", "false"))
        editor.save(PROGRAM)
