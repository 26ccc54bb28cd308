"""Real Neovims with the plugin: what a person sees, the robot that moves, and nothing left after the end."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.editors.editors import LIMIT, ROOT, find, nothing_left

SCRIPTS = Path(__file__).parent / "neovim"
PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"


@pytest.mark.timeout(LIMIT + 60)
@pytest.mark.parametrize(("variable", "fetched"), [("NVIM", "nvim-0.10"), ("NVIM_0_12", "nvim-0.12")])
def test_session(variable: str, fetched: str, tmp_path: Path) -> None:
    neovim = find(variable, f"{fetched}/usr/bin/nvim")
    program = tmp_path / "dance.improv"
    program.write_text(PROGRAM)
    with nothing_left() as env:
        env |= {f"XDG_{kind}_HOME": str(tmp_path / kind) for kind in ("CONFIG", "DATA", "STATE", "CACHE")}
        env |= {
            "IMPROV_ROOT": str(ROOT),
            "IMPROV_PLUGIN": str(ROOT / "editors" / "neovim"),
            "IMPROV_PYTHON": sys.executable,
        }
        init, session = SCRIPTS / "init.lua", f"luafile {SCRIPTS / 'session.lua'}"
        done = subprocess.run(
            [neovim, "--headless", "-i", "NONE", "-n", "-u", str(init), "-c", session, str(program)],
            cwd=tmp_path,
            env=env,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=LIMIT,
        )
    assert done.returncode == 0, done.stderr
