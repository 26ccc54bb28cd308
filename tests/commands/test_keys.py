"""`improv play` in a terminal: keys, and a page that can play the dance again after its end, until Ctrl-C."""

from __future__ import annotations

import asyncio
import os
import pty
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from improv_core.commands import keys
from improv_core.commands.keys import HINT, HINT_ARMED
from tests.commands.command_line import IMPROV, LIMIT, SIMULATED, Running, written
from tests.open_page import connected, heard, live_behind, token_behind

ADDRESS = r"watch it at (\S+)\r?\n"
PROGRAM = "beat 600\nr $ until cue (repeat forward) left\n"


class Printing(Running):
    """A command, and its output, in lines or not."""

    def _print(self, text: str, nl: bool = True, **_: Any) -> None:
        self._lines.put(text + "\n" * nl)


class Keyboard:
    """A terminal in which a program plays, on a thread. The terminal sends it no Ctrl-C."""

    def __init__(self, folder: Path, *options: str) -> None:
        self._ours, self._theirs = pty.openpty()
        self._unread = ""
        self._patch = pytest.MonkeyPatch()
        self._patch.setattr(sys, "stdin", os.fdopen(self._theirs, closefd=False))
        self._patch.setattr(keys, "_in_front", lambda terminal: True)
        self._patch.setattr(sys.stdout, "isatty", lambda: True)
        self._command = Printing("play", written(folder, PROGRAM), *SIMULATED, *options)
        self.interrupt = self._command.interrupt

    def type(self, keys: str) -> None:
        os.write(self._ours, keys.encode())

    def wait(self, pattern: str) -> re.Match[str]:
        """Wait for a match in the output after the previous match."""
        while not (found := re.search(pattern, self._unread)):
            self._unread += self._command.next()
        self._unread = self._unread[found.end() :]
        return found

    def end(self) -> object:
        """Return the exit code."""
        code, rest = self._command.end()
        self.rest = self._unread + "".join(rest)
        return code

    def close(self) -> None:
        if self._command.runs:
            self._command.close()
        sys.stdin.close()
        self._patch.undo()
        for each in (self._ours, self._theirs):
            os.close(each)


Play = Callable[..., Keyboard]


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Play]:
    """Return a function that plays with these options."""
    playing: list[Keyboard] = []

    def begin(*options: str) -> Keyboard:
        playing.append(Keyboard(tmp_path, *options))
        return playing[-1]

    yield begin
    for keyboard in playing:
        keyboard.close()


@pytest.mark.parametrize("key", [" ", "\n"])
def test_a_key_in_the_terminal_begins_an_armed_dance(key: str, play: Play) -> None:
    keyboard = play("--once", "--armed")
    keyboard.wait("armed: all is ready, and begins with Space or Enter, or Play on the page")
    keyboard.wait(re.escape(HINT_ARMED) + " $")
    keyboard.type(key)
    keyboard.wait("beat 1")
    keyboard.type("c")
    assert keyboard.end() == 0


def test_the_terminal_says_when_it_begins_by_itself_and_counts_down(play: Play) -> None:
    keyboard = play("--once", "--at", (datetime.now().astimezone() + timedelta(hours=2)).isoformat())
    keyboard.wait(r"begins at \d\d:\d\d:\d\d (today|tomorrow), or with Space or Enter, or Play on the page")
    keyboard.wait(r"begins in (1:59:\d\d|2:00:00) · ")
    keyboard.wait("begins in 1:59:")
    keyboard.type(" ")
    keyboard.wait("beat 1")
    keyboard.type("c")
    assert keyboard.end() == 0


def test_a_stop_disarms(play: Play) -> None:
    keyboard = play("--once", "--armed")
    keyboard.wait("armed: ")
    keyboard.interrupt()
    assert keyboard.end() == 130
    assert "beat 1" not in keyboard.rest


def test_the_page_plays_a_dance_again_after_its_end(play: Play) -> None:
    keyboard = play()
    address = keyboard.wait(ADDRESS)[1]
    keyboard.wait("▶")
    keyboard.type("c")
    keyboard.wait("press Ctrl-C to end")
    assert asyncio.run(asyncio.wait_for(play_again(live_behind(address)), LIMIT)) == "playing"
    assert token_behind(address) == ""  # it works only once
    for key in ("o", "\n"):
        keyboard.wait(re.escape(HINT) + " $")  # the last line shows what to do
        keyboard.type(key)
        assert token_behind(keyboard.wait(ADDRESS)[1])
    keyboard.interrupt()
    assert keyboard.end() == 0


async def play_again(address: str) -> str:
    """Press Restart on the page and return the state of the dance."""
    async with connected(address) as page:
        await page.send_json({"type": "restart"})
        again = await heard(page, lambda told: told["type"] == "transport" and told["generation"] == 2)
        return str(again["state"])


@pytest.mark.parametrize("owns", [False, True])
def test_keys_count_only_in_the_terminal_of_the_session(owns: bool, tmp_path: Path) -> None:
    """Else, as after `setsid`, they are not for us."""
    ours, theirs = pty.openpty()
    session = ["setsid", "--wait", *(["--ctty"] if owns else [])]
    program = written(tmp_path, "beat 600\nr $ until cue (repeat forward)\n" if owns else "beat 600\nr $ left\n")
    command = [*session, *IMPROV, "play", str(program), *SIMULATED, "--once"]
    os.write(ours, b"c" * owns)
    done = subprocess.run(command, stdin=theirs, capture_output=True, text=True, timeout=LIMIT)
    for each in (ours, theirs):
        os.close(each)
    assert (done.returncode, done.stderr) == (0, "")
    assert "▶ r" in done.stdout
