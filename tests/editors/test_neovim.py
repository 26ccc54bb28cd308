"""Real Neovims with the plugin: what a person sees, the robot that moves, and nothing left after the end."""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.editors import colors, robot
from tests.editors.editors import LIMIT, ROOT, find, nothing_left, slow_server, started_from
from tests.editors.terminal import Terminal, until, written

SCRIPTS = Path(__file__).parent / "neovim"
PLUGIN = ROOT / "editors" / "neovim"
VARIABLES = {"nvim-0.10": "NVIM", "nvim-0.11": "NVIM_0_11", "nvim-0.12": "NVIM_0_12"}
"""The environment variable that names each Neovim. What 0.11 does differently shows in a session."""
PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"


@dataclass(frozen=True, slots=True)
class Neovim:
    """A Neovim that a person has set up as the README says, and a folder with a wrong program."""

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
        """Its environment; in the end, nothing may be left of it."""
        with nothing_left() as env:
            env |= {f"XDG_{kind}_HOME": str(self.folder / kind) for kind in ("CONFIG", "DATA", "STATE", "CACHE")}
            env |= {
                "IMPROV_ROOT": str(ROOT),
                "IMPROV_PLUGIN": str(PLUGIN),
                "IMPROV_PYTHON": sys.executable,
                "IMPROV_PERSON": str(SCRIPTS / "person.lua"),
                "IMPROV_PAGE": str(self.page),
                "LANG": "C.UTF-8",
            }
            yield env

    def check(self, session: str, **env: str) -> None:
        """Go through a session, written in Lua, with the program open."""
        with self.at_work() as its:
            done = subprocess.run(
                self.command("--headless", "-c", f"luafile {SCRIPTS / session}"),
                cwd=self.folder,
                env=its | env,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=LIMIT,
            )
        assert done.returncode == 0, done.stderr


@pytest.fixture(params=["nvim-0.10", "nvim-0.12"])
def neovim(request: pytest.FixtureRequest, tmp_path: Path) -> Neovim:
    fetched = request.param
    found = Neovim(fetched, find(VARIABLES[fetched], f"{fetched}/usr/bin/nvim"), tmp_path)
    found.program.write_text(PROGRAM)
    return found


@pytest.mark.parametrize("neovim", VARIABLES, indirect=True)
@pytest.mark.timeout(LIMIT + 60)
def test_session(neovim: Neovim) -> None:
    neovim.check("session.lua")


@pytest.mark.timeout(LIMIT + 60)
def test_words(neovim: Neovim) -> None:
    neovim.check("words.lua")


@pytest.mark.timeout(LIMIT + 60)
def test_helps(neovim: Neovim) -> None:
    neovim.check("helps.lua")


@pytest.mark.parametrize("neovim", ["nvim-0.12"], indirect=True)
@pytest.mark.parametrize("steps", ["write", "ImprovPlay", "write ImprovPlay ImprovHush"])
@pytest.mark.timeout(LIMIT + 60)
def test_what_is_asked_for_while_the_server_starts(neovim: Neovim, steps: str) -> None:
    neovim.program.write_text("turtle1 $ repeat forward\n")
    server, gate = slow_server(neovim.folder)
    neovim.check("slow.lua", IMPROV_SLOW=str(server), IMPROV_GATE=str(gate), IMPROV_STEPS=steps)


@pytest.mark.timeout(LIMIT + 60)
def test_improv_toml(neovim: Neovim) -> None:
    for name in ("improv.toml", "other.toml"):
        (neovim.folder / name).write_text('[robots.turtle1]\nprofile = "turtlebot3_burgr"\n\n')
    neovim.check("robots.lua")


def test_colors_before_the_server_answers(neovim: Neovim) -> None:
    program, script, env = colors.written(neovim.folder)
    setup = f"set runtimepath^={PLUGIN}"
    options = ["--headless", "-u", "NONE", "-i", "NONE", "-n", "--cmd", setup, "-S", str(script), str(program)]
    subprocess.run([neovim.path, *options], env={**os.environ, **env}, check=True, timeout=LIMIT)
    assert json.loads(Path(env["IMPROV_COLORS"]).read_text()) == colors.in_vim_syntax()


@pytest.mark.timeout(LIMIT + 60)
def test_health_and_help(neovim: Neovim) -> None:
    shutil.copytree(PLUGIN / "doc", neovim.folder / "doc")  # the tags are written beside it
    report = neovim.folder / "report"
    neovim.check("health.lua", IMPROV_REPORT=str(report), IMPROV_DOC=str(neovim.folder / "doc"))
    said = report.read_text(encoding="utf-8")
    assert "ERROR" not in said, said
    for expected in ("OK Neovim 0.1", "OK server: improv-ls ", "OK running in ", "syntax/improv.vim"):
        assert expected in said, said


@pytest.mark.timeout(LIMIT + 60)
def test_screen(neovim: Neovim) -> None:
    with neovim.at_work() as env, Terminal(neovim.folder / "tmux", neovim.command(), env, size=(80, 12)) as terminal:
        terminal.see("E turtle1")  # the error, beside its line
        terminal.write(":w\n")
        terminal.see("✗ line 3: `lft` is not defined")
        assert "Press ENTER" not in terminal.screen()

        terminal.write("/lft\ncwleft\x1b:w\n")
        terminal.see("E turtle1", there=False)
        # Nobody types any more: the words and the status line go on by themselves.
        terminal.see("∞, 120 bpm, simulator")
        beat = next(word for word in terminal.screen().split() if word.endswith("/∞,"))
        terminal.see(beat, there=False)
        dark = terminal.background("repeat")
        assert terminal.background("turtle1") == dark
        for word in ("forward", "left", "forward"):
            _await_light(terminal, word, dark)
        _keep(f"{neovim.name}.ansi", terminal.screen(colors=True))
        asyncio.run(robot.moves(neovim.page.read_text().strip()))

        terminal.write(":ImprovHush\n")
        terminal.see("■ stopped")
        assert {terminal.background(word) for word in ("forward", "left")} == {dark}
        terminal.write(":quit!\n")


@pytest.mark.timeout(LIMIT + 60)
def test_killed(neovim: Neovim) -> None:
    neovim.program.write_text("turtle1 $ repeat forward\n")
    with neovim.at_work() as env:
        command = neovim.command("--headless", "-c", "autocmd LspAttach * ++nested write")
        editor = subprocess.Popen(command, cwd=neovim.folder, env=env, stdin=subprocess.PIPE)
        try:
            asyncio.run(robot.moves(written(neovim.page)))
            assert len(started_from(env)) >= 3  # the editor, its server and the stage
        finally:
            editor.kill()
            editor.wait()


def _await_light(terminal: Terminal, word: str, dark: str) -> None:
    until(lambda: terminal.background(word) != dark, lambda: f"{word} is never lit:\n{terminal.screen()}")


def _keep(name: str, screen: str) -> None:
    """Keep what was seen, for people, where the environment says so."""
    if folder := os.environ.get("IMPROV_ARTIFACTS"):
        Path(folder).mkdir(parents=True, exist_ok=True)
        (Path(folder) / name).write_text(screen, encoding="utf-8")
