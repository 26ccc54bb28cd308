"""Real Neovims with the plugin: their screens, the robot's movement, and no process left after the end."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.editors import colors, robot
from tests.editors.editors import (
    LIMIT,
    ROOT,
    find,
    kill_servers,
    nothing_left,
    program_of,
    servers_from,
    slow_server,
    started_from,
)
from tests.editors.terminal import Terminal, written
from tests.waiting import until

pytestmark = pytest.mark.slow("drives Neovim")

SCRIPTS = Path(__file__).parent / "neovim"
PLUGIN = ROOT / "editors" / "neovim"
VARIABLES = {"nvim-0.10": "NVIM", "nvim-0.12": "NVIM_0_12"}
"""The environment variable that names each Neovim: the oldest that the plugin supports, and the newest."""
PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"


@dataclass(frozen=True, slots=True)
class Neovim:
    """A Neovim that is set up as the README says, and a folder with a wrong program."""

    name: str
    path: str
    folder: Path

    @property
    def program(self) -> Path:
        return self.folder / "dance.improv"

    @property
    def page(self) -> Path:
        return self.folder / "page"

    def command(self, *options: str) -> list[str]:
        return [self.path, *options, "-i", "NONE", "-n", "-u", str(SCRIPTS / "init.lua"), str(self.program)]

    @contextmanager
    def at_work(self) -> Iterator[dict[str, str]]:
        """Yield its environment. On exit, none of its processes may be left."""
        with nothing_left() as env:
            env |= {f"XDG_{kind}_HOME": str(self.folder / kind) for kind in ("CONFIG", "DATA", "STATE", "CACHE")}
            env |= {
                "IMPROV_ROOT": str(ROOT),
                "IMPROV_PLUGIN": str(PLUGIN),
                "IMPROV_PYTHON": sys.executable,
                "IMPROV_PROGRAM": str(self.program),
                "IMPROV_PAGE": str(self.page),
                "LANG": "C.UTF-8",
                "LUA_PATH": f"{SCRIPTS}/?.lua;;",
            }
            yield env

    def check(self, *parts: str, **env: str) -> None:
        """Run a session, written in Lua, with the program open."""
        session = [word for part in parts for word in ("-c", f"luafile {SCRIPTS / part}")]
        with self.at_work() as its:
            done = subprocess.run(
                self.command("--headless", *session, "-c", "quitall!"),
                cwd=self.folder,
                env=its | env,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=LIMIT,
            )
        assert done.returncode == 0, done.stderr


@pytest.fixture(params=VARIABLES)
def neovim(request: pytest.FixtureRequest, tmp_path: Path) -> Neovim:
    fetched = request.param
    found = Neovim(fetched, find(VARIABLES[fetched], f"{fetched}/usr/bin/nvim"), tmp_path)
    found.program.write_text(PROGRAM)
    return found


@pytest.mark.timeout(LIMIT + 60)
def test_session(neovim: Neovim) -> None:
    shutil.copytree(PLUGIN / "doc", neovim.folder / "doc")  # Neovim writes the tags beside it
    report = neovim.folder / "report"
    parts = "session.lua", "health.lua", "words.lua", "robots.lua"
    neovim.check(*parts, IMPROV_REPORT=str(report), IMPROV_DOC=str(neovim.folder / "doc"))
    said = report.read_text(encoding="utf-8")
    assert "ERROR" not in said, said
    for expected in ("OK Neovim 0.1", "OK server: improv-ls ", "OK running in ", "syntax/improv.vim"):
        assert expected in said, said


@pytest.mark.parametrize("neovim", ["nvim-0.12"], indirect=True)
@pytest.mark.timeout(LIMIT + 60)
def test_requests_wait_for_a_server_that_starts(neovim: Neovim) -> None:
    neovim.program.write_text("turtle1 $ repeat forward\n")
    server, gate = slow_server(neovim.folder)
    neovim.check("late.lua", IMPROV_SLOW=str(server), IMPROV_GATE=str(gate))


def test_colors_before_the_server_answers(neovim: Neovim) -> None:
    program, script, env = colors.written(neovim.folder)
    setup = f"set runtimepath^={PLUGIN}"
    options = ["--headless", "-u", "NONE", "-i", "NONE", "-n", "--cmd", setup, "-S", str(script), str(program)]
    subprocess.run([neovim.path, *options], env={**os.environ, **env}, check=True, timeout=LIMIT)
    assert json.loads(Path(env["IMPROV_COLORS"]).read_text()) == colors.in_vim_syntax()


@pytest.mark.timeout(LIMIT + 60)
def test_screen(neovim: Neovim) -> None:
    """In a window of the usual width, no message asks for ENTER, which would hold up all others."""
    server, gate = slow_server(neovim.folder)
    neovim.program.write_text(PROGRAM.replace("lft", "left"))
    with neovim.at_work() as env:
        env["IMPROV_SLOW"] = str(server)
        with Terminal(neovim.folder / "tmux", neovim.command(), env, size=(80, 12)) as terminal:
            _a_late_server_plays_what_was_saved(neovim, terminal, gate)
            _a_person_sees_errors_beats_and_the_words_that_play(terminal)
            _a_killed_server_is_started_again(terminal, env)
            if neovim.name == "nvim-0.12":  # the plugin counts alike in all
                _a_server_that_keeps_ending_stays_off_until_a_save(terminal, env)
            for pid in started_from(env):  # the editor and its screen, while the robot dances
                if program_of(pid) == "nvim":
                    with suppress(ProcessLookupError):  # its screen ends with it
                        os.kill(pid, signal.SIGKILL)


def _a_late_server_plays_what_was_saved(neovim: Neovim, terminal: Terminal, gate: Path) -> None:
    terminal.see("turtle1")
    terminal.write(":w\n")
    terminal.see("Improv is starting; then this program plays")
    assert "ENTER" not in terminal.screen()
    assert terminal.screen().startswith("  beat 120\n")
    terminal.write("Goturtle1 $ (rig")
    gate.touch()
    terminal.see("∞, 120 beats/min, simulator")
    terminal.write("\x1b:undo\n")
    asyncio.run(robot.moves(written(neovim.page)))


def _a_person_sees_errors_beats_and_the_words_that_play(terminal: Terminal) -> None:
    terminal.write("/left\ncwlft\x1b")
    terminal.see("E turtle1")  # the error, beside its line
    terminal.write(":w\n")
    terminal.see("✗ line 3: `lft` is not defined")
    assert "ENTER" not in terminal.screen()
    terminal.write("/lft\ncwleft\x1b:w\n")
    terminal.see("E turtle1", there=False)

    # Without another key, the words and the status line keep changing.
    terminal.see("∞, 120 beats/min, simulator")
    beat = next(word for word in terminal.screen().split() if word.endswith("/∞,"))
    terminal.see(beat, there=False)
    dark = terminal.background("repeat")
    assert terminal.background("turtle1") == dark
    for word in ("forward", "left", "forward"):
        _await_light(terminal, word, dark)

    terminal.write(":ImprovStop\n")
    terminal.see("■ stopped")
    assert {terminal.background(word) for word in ("forward", "left")} == {dark}
    terminal.write(":w\n")
    terminal.see("∞, 120 beats/min, simulator")


def _a_killed_server_is_started_again(terminal: Terminal, env: Mapping[str, str]) -> None:
    terminal.write("Goturtle1 $ (rig\x1b")
    terminal.see("E turtle1 $ (rig")
    killed = kill_servers(env)
    terminal.see("Improv's server ended, and the robots stopped: save to play")
    assert "ENTER" not in terminal.screen()
    terminal.see("simulator", there=False)
    until(lambda: set(servers_from(env)) - set(killed), terminal.screen)
    terminal.see("E turtle1 $ (rig")  # the new one knows the program
    assert terminal.screen().startswith("  beat 120\n")  # and its sign has moved no line
    terminal.write(":undo\n:w\n")
    terminal.see("∞, 120 beats/min, simulator")


def _a_server_that_keeps_ending_stays_off_until_a_save(terminal: Terminal, env: Mapping[str, str]) -> None:
    for _ in range(3):
        kill_servers(env)
        terminal.see("simulator", there=False)
        terminal.write(":w\n")  # also while it starts
        terminal.see("∞, 120 beats/min, simulator")
    kill_servers(env)
    terminal.see("Improv's server keeps ending and stays off: save to start it")
    assert "ENTER" not in terminal.screen()
    terminal.write(":checkhealth improv\n")
    terminal.see("a program is open, but the server is not running")
    terminal.write(":quit\n:w\n")
    terminal.see("∞, 120 beats/min, simulator")


def _await_light(terminal: Terminal, word: str, dark: str) -> None:
    until(lambda: terminal.background(word) != dark, lambda: f"{word} is never lit:\n{terminal.screen()}")
