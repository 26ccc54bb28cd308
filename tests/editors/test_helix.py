"""A real Helix in a terminal (tmux): what a person sees, the robot that moves, and nothing left after the end."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.editors import robot
from tests.editors.editors import LIMIT, ROOT, find, nothing_left
from tests.needs import need

PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"
PATIENCE = 60.0
"""Seconds that anything on the screen may take to come."""


class Terminal:
    """A command in a terminal of its own, which ends with it: `type` what a person types, `see` what stands there."""

    def __init__(self, socket: Path, command: list[str], env: dict[str, str]) -> None:
        self._tmux = [need("tmux"), "-S", str(socket), "-f", "/dev/null", "-u"]
        self._run("new-session", "-d", "-x", "120", "-y", "24", *command, env=env)

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *failure: object) -> None:
        if failure[0] is not None:
            self._run("kill-server")

    def type(self, *keys: str) -> None:
        self._run("send-keys", *keys)

    def see(self, text: str, there: bool = True) -> None:
        """Wait until the text is on the screen, or no longer there."""
        end = time.monotonic() + PATIENCE
        while (text in (screen := self._run("capture-pane", "-p"))) is not there:
            assert time.monotonic() < end, f"{text!r} {'is not' if there else 'is still'} on the screen:\n{screen}"
            time.sleep(0.05)

    def _run(self, *words: str, env: dict[str, str] | None = None) -> str:
        return subprocess.run([*self._tmux, *words], env=env, check=True, capture_output=True, text=True).stdout


@pytest.mark.timeout(LIMIT)
def test_session(tmp_path: Path) -> None:
    helix = find("HELIX", "helix/usr/bin/hx")
    program, page = tmp_path / "dance.improv", tmp_path / "page"
    program.write_text(PROGRAM)
    (tmp_path / "helix").mkdir()
    languages = (ROOT / "editors" / "helix" / "languages.toml").read_text(encoding="utf-8")
    languages += '\n[language-server.improv-ls.config.improv]\nbackend = "sim"\n'
    (tmp_path / "helix" / "languages.toml").write_text(languages)
    browser = tmp_path / "xdg-open"  # the person's browser: it only notes the address
    browser.write_text(f'#!/bin/sh\necho "$1" >"{page}.new" && mv "{page}.new" "{page}"\n')
    browser.chmod(0o755)

    with nothing_left() as env:
        env |= {
            "PATH": f"{tmp_path}:{Path(sys.executable).parent}:{env['PATH']}",
            "XDG_CONFIG_HOME": str(tmp_path),
            "XDG_CACHE_HOME": str(tmp_path / "cache"),
            "LANG": "C.UTF-8",
        }
        with Terminal(tmp_path / "tmux", [helix, str(program)], env) as terminal:
            _session(terminal, page)


def _session(terminal: Terminal, page: Path) -> None:
    terminal.see("●")  # the error, beside its line

    terminal.type("%sforward", "Enter")  # select the word
    terminal.type(" ", "k")
    terminal.see("1 beat, 0.50 s at beat 120")

    terminal.type("Escape")
    terminal.see("1 beat, 0.50 s at beat 120", there=False)
    terminal.type("%slft", "Enter")
    terminal.see("`lft` is not known: did you mean `left`?")
    terminal.type("c", "left", "Escape")
    terminal.see("●", there=False)
    terminal.type(":w", "Enter")
    terminal.see("▶ turtle1 ∞, endless at beat 120, simulator")

    end = time.monotonic() + PATIENCE
    while not page.exists():
        assert time.monotonic() < end, "no page was opened"
        time.sleep(0.05)
    url = page.read_text().strip()
    asyncio.run(robot.moves(url))
    terminal.type(":lsp-workspace-command improv.hush", "Enter")
    asyncio.run(robot.stands(url))
    terminal.type(":lsp-workspace-command improv.play", "Enter")
    asyncio.run(robot.moves(url))
    terminal.type(":quit!", "Enter")
