"""A real Vim with ALE, set up as its page says: its screen, the robot's movement, no process left."""

from __future__ import annotations

import asyncio
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest

from tests.editors import colors, robot
from tests.editors.editors import LIMIT, ROOT, nothing_left, noting_browser
from tests.editors.terminal import Terminal, written
from tests.needs import lacking, need

pytestmark = pytest.mark.slow("drives Vim")

FOLDER = ROOT / "editors" / "vim"
ALE = Path("/usr/share/vim-ale")


@pytest.mark.timeout(LIMIT)
def test_session(tmp_path: Path) -> None:
    vim = need("vim")
    if not ALE.is_dir():
        lacking("vim-ale is not installed")
    (blocks,) = re.findall(r"```vim\n(.*?)```", (FOLDER / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "vimrc").write_text(
        f"set nocompatible runtimepath^={ALE}\n"
        + dedent(blocks).replace("/path/to/improv/editors/vim", str(FOLDER))
        + "let g:ale_improv_config = {'improv': {'backend': 'sim'}}\n"
    )
    page = tmp_path / "page"
    noting_browser(tmp_path / "browser", page)
    (tmp_path / "improv-ls").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m improv_ls\n')
    (tmp_path / "improv-ls").chmod(0o755)
    (tmp_path / "dance.improv").write_text("beat 120\n\nturtle1 $ repeat (forward lft)\n")
    command = [vim, "-u", str(tmp_path / "vimrc"), "-i", "NONE", "-n", str(tmp_path / "dance.improv")]
    with nothing_left() as env:
        env |= {"LANG": "C.UTF-8", "DISPLAY": ":none", "BROWSER": f"{tmp_path}/browser"}
        env["PATH"] = f"{tmp_path}:{env['PATH']}"
        with Terminal(tmp_path / "tmux", command, env) as terminal:
            terminal.see("`lft` is not defined: did you mean `left`?")
            terminal.type(
                "/repeat", "Enter", ":call setline(2, '# ' .. synIDattr(synID(3, col('.'), 1), 'name'))", "Enter"
            )
            terminal.see("# improvTransformer")
            terminal.type(":%s/lft/left/", "Enter", ":w", "Enter")
            terminal.see("▶ turtle1 ∞, endless at beat 120, simulator")
            url = written(page)
            asyncio.run(robot.moves(url))
            terminal.type(":ImprovStop", "Enter")
            asyncio.run(robot.stands(url))
            page.unlink()
            terminal.type(":ImprovPage", "Enter")
            url = written(page)
            terminal.type(":ImprovPlay", "Enter")
            asyncio.run(robot.moves(url))
            terminal.type(":call append(3, ['wide = up', 'bob $ left'])", "Enter", ":5ImprovPlay", "Enter")
            terminal.see("▶ line 5: bob 1 beat, 0.50 s at beat 120, simulator")
            terminal.type(":ImprovPlay wide", "Enter")
            terminal.see("▶ wide: ghost 1 beat")
            terminal.type(":quit!", "Enter")


def test_colors_before_the_server_answers(tmp_path: Path) -> None:
    program, script, env = colors.written(tmp_path)
    setup = f"set nocompatible runtimepath^={FOLDER}"
    command = [need("vim"), "-u", "NONE", "-i", "NONE", "-n", "-es", "--cmd", setup, "-S", str(script), str(program)]
    subprocess.run(command, env={**os.environ, **env}, check=True, timeout=LIMIT)
    assert json.loads(Path(env["IMPROV_COLORS"]).read_text()) == colors.in_vim_syntax()
