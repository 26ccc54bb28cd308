"""`improv play` in a terminal: keys, and a page that can play the dance again after its end, until Ctrl-C."""

from __future__ import annotations

import asyncio
import os
import pty
import re
import select
import subprocess
from collections.abc import Iterator
from datetime import datetime, timedelta
from pathlib import Path

import aiohttp
import pytest

from improv_core.commands.terminal import HINT, HINT_ARMED
from tests.commands.command_line import IMPROV, LIMIT
from tests.page import live_behind, token_behind

ADDRESS = r"watch it at (\S+)\r\n"


class Terminal:
    """A terminal in which a program plays, with a keyboard."""

    def __init__(self, folder: Path, program: str) -> None:
        (folder / "dance.improv").write_text(program)
        self._ours, self.theirs = pty.openpty()
        self.command = [*IMPROV, "play", str(folder / "dance.improv"), "--backend", "sim", "--no-browser"]
        self._process: subprocess.Popen[bytes] | None = None
        self._unread = ""

    def play(self, *options: str) -> None:
        """In a session of its own, whose terminal this is."""
        command = ["setsid", "--ctty", "--wait", *self.command, *options]
        self._process = subprocess.Popen(command, stdin=self.theirs, stdout=self.theirs, stderr=self.theirs)

    def type(self, keys: str) -> None:
        os.write(self._ours, keys.encode())

    def wait(self, pattern: str) -> re.Match[str]:
        """What fits in that which is shown after what was waited for before."""
        while not (found := re.search(pattern, self._unread)):
            self._unread += os.read(self._ours, 1024).decode(errors="replace")
        self._unread = self._unread[found.end() :]
        return found

    def rest(self) -> str:
        """What is shown after that, up to now."""
        while select.select([self._ours], [], [], 0)[0]:
            self._unread += os.read(self._ours, 1024).decode(errors="replace")
        return self._unread

    def end(self) -> int:
        """The exit code."""
        assert self._process
        return self._process.wait(LIMIT)

    def close(self) -> None:
        if self._process:
            self._process.kill()
            self._process.wait()
        for each in (self._ours, self.theirs):
            os.close(each)


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    terminal = Terminal(tmp_path, "beat 600\nr $ until cue (repeat forward) left\n")
    yield terminal
    terminal.close()


def test_a_key_in_the_terminal_gives_the_cue(terminal: Terminal) -> None:
    terminal.play("--once")
    terminal.wait("▶")
    terminal.type("xc")
    assert terminal.end() == 0


@pytest.mark.parametrize("key", [" ", "\n"])
def test_a_key_in_the_terminal_begins_what_is_armed(terminal: Terminal, key: str) -> None:
    terminal.play("--armed", "--once")
    terminal.wait("armed: all is ready, and begins with Space or Enter, or Play on the page")
    terminal.wait(re.escape(HINT_ARMED) + " $")
    terminal.type(key)
    terminal.wait("beat 1")
    terminal.type("c")
    assert terminal.end() == 0


def test_the_terminal_says_when_it_begins_by_itself_and_counts_down(terminal: Terminal) -> None:
    terminal.play("--at", (datetime.now().astimezone() + timedelta(hours=2)).isoformat(), "--once")
    terminal.wait(r"begins at \d\d:\d\d:\d\d (today|tomorrow), or with Space or Enter, or Play on the page")
    terminal.wait(r"begins in (1:59:\d\d|2:00:00) · ")
    terminal.wait("begins in 1:59:")
    terminal.type(" ")
    terminal.wait("beat 1")
    terminal.type("c")
    assert terminal.end() == 0


def test_a_stop_disarms(terminal: Terminal) -> None:
    terminal.play("--armed", "--once")
    terminal.wait("armed: ")
    terminal.type("\x03")
    assert terminal.end() == 130
    assert "beat 1" not in terminal.rest()


def test_the_page_plays_a_dance_again_after_its_end(terminal: Terminal) -> None:
    terminal.play()
    address = terminal.wait(ADDRESS)[1]
    terminal.wait("▶")
    terminal.type("c")
    terminal.wait("press Ctrl-C to end")
    assert asyncio.run(asyncio.wait_for(play_again(live_behind(address)), LIMIT)) == "playing"
    assert token_behind(address) == ""  # it works only once
    for key in ("o", "\n"):
        terminal.wait(re.escape(HINT) + " $")  # the last line says what to do
        terminal.type(key)
        assert token_behind(terminal.wait(ADDRESS)[1])
    terminal.type("\x03")
    assert terminal.end() == 0


async def play_again(address: str) -> str:
    """The state of the dance after Restart was pressed on the page."""
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(address, origin=address.split("/live")[0]) as page,
    ):
        await page.send_json({"type": "restart"})
        async for message in page:
            told = message.json()
            if told["type"] == "transport" and told["generation"] == 2:
                return str(told["state"])
    raise AssertionError("the page was closed")


def test_a_dance_plays_in_a_session_that_has_no_terminal_of_its_own(terminal: Terminal, tmp_path: Path) -> None:
    """As after `setsid`: its input is a terminal, but no key in it is for us."""
    (tmp_path / "dance.improv").write_text("beat 600\nr $ left\n")
    done = subprocess.run(
        terminal.command,
        stdin=terminal.theirs,
        capture_output=True,
        text=True,
        start_new_session=True,
        timeout=LIMIT,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "▶ r 1 beat" in done.stdout
