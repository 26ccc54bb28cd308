"""Measured movements of robots, over ROS: poses of each type, from their topics to the page."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from aiohttp import ClientSession

from improv_core.outputs.ros.sensors.poses import TEXTS
from tests.ls.client import ProcessClient
from tests.open_page import live_behind
from tests.ros.conftest import BASE, LIMIT, Listen, Publish, Script, Sink
from tests.ros.dance import moving, still

pytestmark = pytest.mark.slow("processes of ROS find each other")

CMD = {"anna": "/anna/cmd_vel"}
BEATS = 4
PROGRAM = "beat 60\nanna bert $ forward slow 2 left forward\n"
FRAMES = 0.3
"""Meters of error by late commands on a busy machine; a robot in a wrong frame is meters off."""
ROBOTS = """
[robots.anna]
profile = "turtlebot4"
odom = "odom"
[robots.bert]
profile = "turtlebot4"
odom = "true_pose"
follow = true
start = { x = 0, y = 2, heading = 90 }
"""


def fields(kind: str, x: float, heading: float) -> dict[str, float]:
    """Return a message with a heading; its stamp is from 1970."""
    pose = "pose" if kind == "geometry_msgs/PoseStamped" else "pose.pose"
    turn = {f"{pose}.orientation.z": math.sin(heading / 2), f"{pose}.orientation.w": math.cos(heading / 2)}
    return {f"{pose}.position.x": x, **turn}


@pytest.mark.parametrize("kind", TEXTS)
def test_poses_of_each_type_and_with_any_stamps_are_read(kind: Any, publish: Publish, sink: Sink) -> None:
    topic = f"/anna/{kind.rpartition('/')[2]}"
    publish(topic, kind)(fields(kind, 1.5, 2.0))
    sink("prepare", CMD, odom=topic)
    (robot, source, x, y, heading), ago = sink("pose")
    assert (robot, source, x, y, heading) == ("anna", kind, 1.5, 0, 2.0)
    assert 0 <= ago < LIMIT


def test_a_robot_that_moves_without_a_pose_is_named(publish: Publish, sink: Sink) -> None:
    what = "anna's real position is unknown"
    sink("prepare", CMD, odom="/anna/odom")
    sink("send", "anna", 1, 0, 0, 0)
    assert sink("find", "warnings", "anna", what) == f"nobody publishes on /anna/odom: {what}"
    poses = publish("/anna/odom", "nav_msgs/Odometry")
    poses(fields("nav_msgs/Odometry", 0, 0))
    sink("until_no_warnings")
    poses(None)  # from now on, that is a fault of the robot
    sink("prepare", CMD, odom="/anna/cmd_vel")
    sink("send", "anna", 1, 0, 0, 0)
    assert "/anna/cmd_vel carries geometry_msgs/Twist, not nav" in sink("find", "warnings", "anna", "carries")


def test_the_level_of_a_battery_is_read(publish: Publish, sink: Sink) -> None:
    sink("prepare", CMD, battery="/anna/battery")
    publish("/anna/battery", "sensor_msgs/BatteryState")({"percentage": 0.42})
    assert sink("battery", "anna") == pytest.approx(0.42)


async def measured(url: str, until: Callable[[Mapping[str, list[list[float]]]], bool]) -> dict[str, list[list[float]]]:
    """Return the measured places of robots, as a page gets them."""
    live = live_behind(url)
    found: dict[str, list[list[float]]] = {}
    origin = {"Origin": live[: live.index("/live")]}
    async with asyncio.timeout(LIMIT), ClientSession() as session, session.ws_connect(live, headers=origin) as page:
        while not until(found):
            message = await page.receive_json()
            if message["type"] == "measured":
                for robot, trail in message["robots"].items():
                    found.setdefault(robot, [])[trail["from"] :] = trail["places"]
    return found


def test_the_page_shows_the_measured_places_of_bases(
    script: Script, listen: Listen, ros_env: dict[str, str], tmp_path: Path
) -> None:
    """One also gets corrections that bring it back to its path. tests/outputs/test_bases.py tests their accuracy."""
    script(BASE, "anna", "--noise", "0", "--loss", "0")
    script(BASE, "bert", "--wheel-error", "0.96", "0.94", "--start", "5", "6", "1")
    told = listen("/bert/cmd_vel")
    (tmp_path / "improv.toml").write_text(ROBOTS)
    program = tmp_path / "dance.improv"
    program.write_text(PROGRAM)
    with ProcessClient({"backend": "both", "page": {"open": False}}, env=ros_env) as client:
        client.open(program.as_uri(), PROGRAM)
        client.save(program.as_uri())
        client.wait_for_line("▶")
        url = client.request("workspace/executeCommand", {"command": "improv.page"})
        found = asyncio.run(
            measured(url, lambda found: len(found) == 2 and all(p[-1][1] == BEATS for p in found.values()))
        )
        told.wait(moving)  # the zeros before that only check that it hears
        for _ in range(3):
            told.wait(still)
    for places in found.values():
        assert {place[10] for place in places} == {1}
        beats = [place[1] for place in places]
        assert beats == sorted(beats)
    last = found["anna"][-1]
    assert last[11] == 0, "it is not simulated"
    # A change that a busy machine sends 0.9 s late is 0.18 m at 0.2 m/s; one that hasn't moved would be 0.2 m off.
    assert last[5:7] == pytest.approx([0.2, 0.2], abs=0.18)
    assert last[7] == pytest.approx(math.pi / 2, abs=0.8)
    for places in found.values():
        off, turned = places[-1][8:10]
        assert off < FRAMES, "the other one is in a frame of its own"
        assert turned < math.radians(45)
    assert {message["x"] for message in told.heard} - {0, 0.2}, "it follows its path"
    assert [(message["x"], message["yaw"]) for message in told.heard[-3:]] == [(0, 0)] * 3
