"""A real Helix in a terminal, set up as its page says: its screen, the robot's movement, no process left."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import signal
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from textwrap import dedent

import pytest

from improv_ls.editor import READING
from tests.editors import robot
from tests.editors.editors import (
    LIMIT,
    ROOT,
    find,
    follow,
    kill_servers,
    nothing_left,
    noting_browser,
    program_of,
    servers_from,
    slow_server,
    started_from,
)
from tests.editors.terminal import Terminal, cells, written
from tests.waiting import until

pytestmark = pytest.mark.slow("drives Helix")

PAGE = (ROOT / "editors" / "helix" / "README.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def settings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The settings that the commands on Helix's page make in an empty home."""
    _helix()
    home = tmp_path_factory.mktemp("helix")
    for commands in 2 * _blocks("sh"):  # they can be repeated
        follow(commands, _settings_in(home))
    return home / ".config"


@pytest.fixture
def home(settings: Path, tmp_path: Path) -> Path:
    """Return the test's own home, in which Helix is set up."""
    shutil.copytree(settings, tmp_path / ".config")
    return tmp_path


def test_colors_and_indentation(home: Path) -> None:
    """test_tree_sitter.py has the colors of all words."""
    theme = home / ".config" / "helix" / "themes" / "scopes.toml"
    theme.parent.mkdir()
    theme.write_text('"ui.selection" = {}\n"keyword.control" = "#010203"\n', encoding="utf-8")
    program = "\nbeat 60\nsq = (\n  slow 3/2 left # why\n)\nr $ reflect YZ sq || rest up [left]\nfast (\n"
    with helix(home, program, 'theme = "scopes"\n[editor]\ntrue-color = true\n') as (terminal, _):

        def colored() -> str:
            letters = [cell for line in cells(terminal.screen(colors=True)) for cell in line]
            return "".join(cell.letter for cell in letters if cell.color == "2;1;2;3")

        until(lambda: colored() == "slowreflectfast", colored)
        terminal.type("3G", "o", "rest", "Enter", "forward")
        terminal.see("    forward")
        assert re.search(r"sq = \(\n\W+4    rest\n\W+5    forward\n\W+6    slow", terminal.screen())
        _escape(terminal)
        terminal.type(":quit!", "Enter")


@pytest.mark.timeout(LIMIT)
def test_session(home: Path) -> None:
    with helix(home, "beat 120\n\nturtle1 $ repeat (forward lft)\n", _config()) as (terminal, _):
        terminal.see("●")  # the error, beside its line

        terminal.type("%sforward", "Enter")  # select the word
        terminal.type(" ", "k")
        terminal.see("1 beat, 0.50 s at beat 120")
        _escape(terminal)
        terminal.see("1 beat, 0.50 s at beat 120", there=False)

        terminal.type("%slft", "Enter")
        terminal.see("`lft` is not defined: did you mean `left`?")
        terminal.type("c", "halfleft")
        _escape(terminal)
        terminal.see("●", there=False)

        terminal.type(":w", "Enter")
        first = _beat(terminal)
        url = written(home / "page")
        asyncio.run(robot.moves(url))
        _beat(terminal, first + 2)  # it counts on

        terminal.type("%sforward", "Enter", "c", "forwad")
        _escape(terminal)
        terminal.see("`forwad` is not defined: did you mean `forward`?")
        last = _beat(terminal)
        terminal.type(":w", "Enter")
        terminal.see("✗ line 3: `forwad` is not defined")
        assert _beat(terminal) >= last + 2 * READING  # at beat 120; until then, one can read the message
        until(lambda: "forwad" in (home / "dance.improv").read_text(encoding="utf-8"), terminal.screen)
        asyncio.run(robot.moves(url))

        terminal.type(":lsp-workspace-command improv.stop", "Enter")
        asyncio.run(robot.stands(url))
        terminal.type("u")
        terminal.see("●", there=False)
        terminal.type("F5")
        asyncio.run(robot.moves(url))
        terminal.type("2", "G", "F7")
        terminal.see("✗ there is nothing to play on line 2")
        terminal.type("i", "F6")
        asyncio.run(robot.stands(url))
        _escape(terminal)
        _helps_in_improv_toml(terminal, home)
        terminal.type(":quit-all!", "Enter")


def _helps_in_improv_toml(terminal: Terminal, folder: Path) -> None:
    robots = folder / "improv.toml"
    robots.write_text('[robots.turtle1]\nprofile = "turtlebot3_burgr"\n', encoding="utf-8")
    terminal.type(f":open {robots}", "Enter")
    terminal.see("burgr")
    terminal.see("●")
    terminal.type("j", "Space", "k")
    terminal.see("the kind of robot")
    _escape(terminal)


@pytest.mark.timeout(LIMIT)
def test_a_server_that_is_late_or_killed_and_a_killed_helix(home: Path) -> None:
    """Helix sends a server no save from before its start, and restarts no killed server: its page says so."""
    server, gate = slow_server(home)
    (home / "improv-ls").symlink_to(server)
    with helix(home, "x = left\nturtle1 $ repeat forward\n", _config()) as (terminal, env):
        until(lambda: servers_from(env), terminal.screen)
        terminal.type(":w", "Enter")
        terminal.see("written")
        gate.touch()
        terminal.see("●")  # the server runs, and has not got the save
        assert "▶" not in terminal.screen()
        terminal.type(":w", "Enter")
        _beat(terminal)
        asyncio.run(robot.moves(written(home / "page")))

        killed = kill_servers(env)
        terminal.see("beat", there=False)
        terminal.see("●", there=False)
        assert "`:lsp-restart`" in PAGE
        terminal.type(":lsp-restart", "Enter")
        until(lambda: set(servers_from(env)) - set(killed), terminal.screen)
        terminal.see("●")
        terminal.type(":w", "Enter")
        _beat(terminal)
        (editor,) = (pid for pid in started_from(env) if program_of(pid) == "hx")
        os.kill(editor, signal.SIGKILL)  # while the robot dances


@contextmanager
def helix(home: Path, program: str, config: str) -> Iterator[tuple[Terminal, Mapping[str, str]]]:
    """Yield a terminal in which Helix shows the program, and Helix's environment."""
    folder = home / ".config" / "helix"
    (folder / "config.toml").write_text(config, encoding="utf-8")
    with (folder / "languages.toml").open("a", encoding="utf-8") as languages:
        languages.write('\n[language-server.improv-ls.config.improv]\nbackend = "sim"\n')
    noting_browser(home / "xdg-open", home / "page")
    (home / "dance.improv").write_text(program, encoding="utf-8")
    with nothing_left() as env:
        env |= _settings_in(home) | {"LANG": "C.UTF-8", "COLORTERM": "truecolor", "DISPLAY": ":0"}
        env["PATH"] = f"{home}:{Path(sys.executable).parent}:{env['PATH']}"
        with Terminal(home / "tmux", [_helix(), str(home / "dance.improv")], env) as terminal:
            terminal.see("NOR")  # now it takes keys
            yield terminal, env


def _helix() -> str:
    return find("HELIX", "helix/usr/bin/hx")


def _settings_in(home: Path) -> dict[str, str]:
    """Return the environment in which programs look for their settings in this home."""
    return {"HOME": str(home), **{f"XDG_{kind}_HOME": "" for kind in ("CONFIG", "CACHE", "DATA", "STATE")}}


def _config() -> str:
    return "".join(_blocks("toml"))


def _blocks(language: str) -> list[str]:
    return [dedent(block) for block in re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)]


def _beat(terminal: Terminal, least: int = 1) -> int:
    """Wait for a beat in the status line that is at least this, and return it."""

    def seen() -> int:
        beats = re.findall(r"beat (\d+)/∞", terminal.screen())
        return int(beats[0]) if beats and int(beats[0]) >= least else 0

    return until(seen, terminal.screen)


def _escape(terminal: Terminal) -> None:
    terminal.write("\x1b[27u")  # a byte alone and the next key might be taken for one
