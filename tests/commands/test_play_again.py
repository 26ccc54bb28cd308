"""`improv play` in a terminal: after the dance its page can play it again, until Ctrl-C."""

from __future__ import annotations

import asyncio
import os
import pty
import re
import subprocess
from pathlib import Path

import aiohttp

from tests.commands.command_line import IMPROV, LIMIT
from tests.page import live_behind


def test_the_page_plays_a_dance_again_after_its_end(tmp_path: Path) -> None:
    program = tmp_path / "dance.improv"
    program.write_text("beat 600\nr $ left\n")
    ours, theirs = pty.openpty()
    command = [*IMPROV, "play", str(program), "--backend", "sim", "--no-browser"]
    # In a session of its own, whose terminal this is.
    process = subprocess.Popen(
        ["setsid", "--ctty", "--wait", *command], stdin=theirs, stdout=theirs, stderr=theirs, cwd=tmp_path
    )
    os.close(theirs)
    try:
        said = ""
        while "press Ctrl-C to end" not in said:
            said += os.read(ours, 1024).decode(errors="replace")
        found = re.search(r"watch it at (\S+)", said)
        assert found
        assert asyncio.run(asyncio.wait_for(play_again(live_behind(found[1])), LIMIT)) == ["playing", "ended"]
        os.write(ours, b"\x03")
        assert process.wait(LIMIT) == 0
    finally:
        process.kill()
        process.wait()
        os.close(ours)


async def play_again(address: str) -> list[str]:
    """The states of the dance after Restart was pressed on the page."""
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(address, origin=address.split("/live")[0]) as page,
    ):
        await page.send_json({"type": "restart"})
        states: list[str] = []
        async for message in page:
            told = message.json()
            if told["type"] == "transport" and told["generation"] == 2 and told["state"] not in states:
                states.append(told["state"])
            if states[-1:] == ["ended"]:
                break
        return states
