"""A dance of a child on a real robot: only once the teacher has looked at it, and until the teacher's stop."""

from __future__ import annotations

import asyncio
import re
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

import aiohttp
import pytest

from tests.commands.command_line import IMPROV
from tests.open_page import connected, heard, live_behind, stop_by
from tests.ros.conftest import LIMIT, Listen
from tests.ros.dance import moving, still
from tests.website.conftest import built, pyodide

__all__ = ["built", "pyodide"]
pytestmark = pytest.mark.slow("starts a class with its stages, and a robot drives")


@pytest.fixture
def said(alone: Mapping[str, str], built: Path, tmp_path: Path) -> Iterator[tuple[str, str, str]]:
    """The lines of a class that has a real robot: the children's address, the code, and the teacher's address."""
    robots = tmp_path / "improv.toml"
    robots.write_text('[robots.turtle1]\nprofile = "turtlesim"\n')
    command = [*IMPROV, "class", str(built), "--address", "127.0.0.1", "--port", "0", "--robots", str(robots)]
    command += ["--folder", str(tmp_path / "dances")]
    with subprocess.Popen(command, text=True, env=alone, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as running:
        assert running.stdout
        lines = ""
        while not (found := re.search(r"children: (\S+), code (\S+)\s.*teacher: (\S+) ", lines, re.DOTALL)):
            line = running.stdout.readline()
            assert line, lines
            lines += line
        yield found[1], found[2], found[3]
        running.terminate()
        running.communicate(timeout=LIMIT)


def test_a_real_robot_performs_only_what_was_looked_at_and_stops(said: tuple[str, str, str], listen: Listen) -> None:
    address, code, teacher = said
    turtle = listen("/turtle1/cmd_vel")

    async def scenario() -> None:
        own = {"Origin": address.rstrip("/")}
        async with aiohttp.ClientSession(headers=own) as child, asyncio.timeout(3 * LIMIT):
            async with child.post(f"{address}class/join", json={"code": code, "name": "turtle1"}) as answer:
                bearer = {"Authorization": f"Bearer {(await answer.json())['secret']}"}

            async def send(text: str) -> None:
                status = 429
                while status == 429:  # once in a second
                    async with child.post(f"{address}class/send", data=text, headers=bearer) as answer:
                        status = answer.status
                assert status == 200

            live = live_behind(teacher)
            async with connected(live) as page:
                await heard(page, lambda told: told == {"type": "robots", "names": ["turtle1"]})
                await send("r $ repeat forward")
                await heard(page, lambda told: told["type"] == "child" and told["good"])
                await page.send_json({"type": "play", "numbers": [1]})  # a child that is called as the robot
                await heard(page, lambda told: told == {"type": "playing", "line": "turtle1"})
                perform = {"type": "perform", "number": 1, "count": 1, "robot": "turtle1"}
                await page.send_json({**perform, "robot": "ada"})  # not in the file
                await page.send_json({**perform, "count": 2})
                await heard(page, lambda told: told["type"] == "playing" and "look at it first" in told["line"])
                turtle.hear_all()
                assert not [each for each in turtle.heard if moving(each)]
                await page.send_json(perform)
                await asyncio.to_thread(turtle.wait, moving)
                await send("r $ repeat backward")
                await heard(page, lambda told: told["type"] == "child" and (told["good"] or {}).get("count") == 2)
                turtle.hear_all()
                assert turtle.heard[-1]["x"] == 2  # what the teacher has looked at
                assert (await asyncio.to_thread(stop_by, live))[0] == 204
                await asyncio.to_thread(turtle.wait, still)
                turtle.heard.clear()
                await page.send_json({"type": "play", "numbers": [1]})
                await heard(page, lambda told: told == {"type": "playing", "line": "turtle1"})
                turtle.hear_all()
                assert all(map(still, turtle.heard))

    asyncio.run(scenario())
