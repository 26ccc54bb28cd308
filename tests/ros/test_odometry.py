"""What robots really did, over ROS: poses of each type, from their topics to the page."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from aiohttp import ClientSession

from improv_core.stage.sinks.ros_poses import TEXTS
from tests.ls.client import Client
from tests.page import live_behind
from tests.ros.conftest import LIMIT, Script, Sense, Sink
from tests.ros.test_base import BASE

CMD = {"anna": "/anna/cmd_vel"}
PROGRAM = "beat 60\nanna bert $ repeat 2 (forward slow 2 left)\n"
ROBOTS = """
[robots.anna]
profile = "turtlebot4"
odom = "odom"
[robots.bert]
profile = "turtlebot4"
odom = "true_pose"
start = { x = 0, y = 2, heading = 90 }
"""


def fields(kind: str, x: float, heading: float) -> dict[str, float]:
    """A message at a heading; its stamp is that of 1970."""
    pose = "pose" if kind == "geometry_msgs/PoseStamped" else "pose.pose"
    turn = {f"{pose}.orientation.z": math.sin(heading / 2), f"{pose}.orientation.w": math.cos(heading / 2)}
    return {f"{pose}.position.x": x, **turn}


@pytest.mark.parametrize("kind", TEXTS)
def test_poses_of_each_type_from_another_clock(kind: Any, sensor: Sense, sink: Sink) -> None:
    publish = sensor("/anna/where", kind)
    publish(fields(kind, 1.5, 2.0))
    sink("prepare", CMD, odom="/anna/where")
    (robot, source, x, y, heading), ago = sink("pose")
    assert (robot, source, x, y, heading) == ("anna", kind, 1.5, 0, 2.0)
    assert 0 <= ago < LIMIT


def test_a_robot_whose_poses_stop_while_it_moves_is_named(sensor: Sense, sink: Sink) -> None:
    what = "anna's real position is unknown"
    sink("prepare", CMD, odom="/anna/odom")
    sink("send", "anna", 1, 0, 0, 0)
    assert sink("find", "warnings", "anna", what) == f"nobody publishes on /anna/odom: {what}"
    publish = sensor("/anna/odom", "nav_msgs/Odometry")
    publish(fields("nav_msgs/Odometry", 0, 0))
    sink("until_no_warnings")
    publish(None)
    assert sink("find", "warnings", "anna", "no pose") == f"no poses arrive on /anna/odom: {what}"
    sink("send", "anna", 0, 0, 0, 0)
    sink("until_no_warnings")
    sink("prepare", CMD, odom="/anna/cmd_vel")
    sink("send", "anna", 1, 0, 0, 0)
    assert "/anna/cmd_vel carries geometry_msgs/Twist, not nav" in sink("find", "warnings", "anna", "carries")


async def measured(url: str, until: Callable[[Mapping[str, list[list[float]]]], bool]) -> dict[str, list[list[float]]]:
    """The places at which robots were measured, as a page gets them."""
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


def test_from_a_save_to_where_the_page_shows_that_bases_really_were(
    script: Script, ros_env: dict[str, str], tmp_path: Path
) -> None:
    script(BASE, "anna", "--noise", "0", "--loss", "0")
    script(BASE, "bert", "--wheel-error", "0.96", "0.94", "--start", "5", "6", "1")
    (tmp_path / "improv.toml").write_text(ROBOTS)
    program = tmp_path / "dance.improv"
    program.write_text(PROGRAM)
    with Client({"backend": "both", "page": {"open": False}}, env=ros_env) as client:
        client.open(program.as_uri(), PROGRAM)
        client.save(program.as_uri())
        client.wait_for_line("▶")
        url = client.request("workspace/executeCommand", {"command": "improv.page"})
        # Beat 6 is the end. At rest, a base is measured for another second.
        found = asyncio.run(
            measured(url, lambda found: len(found) == 2 and all(p[-1][0] > 6.5 for p in found.values()))
        )
    for places in found.values():
        assert {place[10] for place in places} == {1}
        assert len(places) <= 7.1 * 20
        beats = [place[1] for place in places]
        assert beats == sorted(beats)
    last = found["anna"][-1]
    off, turned = last[8:10]
    assert (last[1], last[11]) == (6, 0)  # the beat, and that it is not simulated
    assert last[5:8] == pytest.approx([0.2, 0.2, math.pi], abs=1e-3)
    assert off < 0.08
    assert turned < math.radians(10)
    # The other one is in a frame of its own, and its wheels roll too little: it is where the simulator has foreseen.
    off, turned = found["bert"][-1][8:10]
    assert 0.003 < off < 0.15
    assert math.radians(2) < turned < math.radians(22)
