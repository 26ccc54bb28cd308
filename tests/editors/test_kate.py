"""A real Kate, set up as docs/editors.md says, without a monitor: a save moves the robot, and nothing is left."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.editors import robot
from tests.editors.editors import LIMIT, ROOT, nothing_left, noting_browser, started_from
from tests.editors.terminal import written
from tests.needs import need
from tests.waiting import until

pytestmark = pytest.mark.slow("drives Kate")

FOLDER = ROOT / "editors" / "kate"
SERVER = Path(sys.executable).with_name("improv-ls")
PROGRAM = "turtle1 $ repeat (forward left)\n"


@pytest.mark.timeout(LIMIT)
def test_session(tmp_path: Path) -> None:
    kate, program, page = need("kate"), tmp_path / "dance.improv", tmp_path / "page"
    program.write_text(PROGRAM)
    with nothing_left() as env, _screen() as display:
        env |= _set_up(tmp_path, page) | {"DISPLAY": display}
        editor = subprocess.Popen([kate, str(program)], cwd=tmp_path, env=env, stderr=subprocess.DEVNULL)
        try:
            # The server prepares to play as soon as it has the program.
            until(lambda: any("IMPROV_PAGE_TOKEN" in its for its in started_from(env).values()), lambda: "no stage")
            _press(env, "ctrl+End", "numbersign", "ctrl+s")
            asyncio.run(robot.moves(written(page)))
            assert program.read_text().startswith(f"{PROGRAM}#")
            _press(env, "ctrl+q")
            assert editor.wait(LIMIT) == 0
        finally:
            editor.kill()


def _set_up(home: Path, page: Path) -> dict[str, str]:
    """Copy the recipe's files, and make a browser that only writes the address to a file. Return the environment."""
    given = json.loads((FOLDER / "settings.json").read_text(encoding="utf-8"))
    given["servers"]["improv"]["settings"] = {"improv": {"backend": "sim"}}
    syntax, client = home / "data/org.kde.syntax-highlighting/syntax", home / "config/kate/lspclient"
    for folder in (syntax, client):
        folder.mkdir(parents=True)
    (syntax / "improv.xml").write_bytes((FOLDER / "improv.xml").read_bytes())
    (client / "settings.json").write_text(json.dumps(given))
    # As if Kate had asked whether it may start the server.
    (home / "config" / "katerc").write_text(f"[lspclient]\nAllowedServerCommandLines={SERVER}\n")
    noting_browser(home / "browser", page)
    folders = {f"XDG_{kind.upper()}_HOME": str(home / kind) for kind in ("config", "data", "state", "cache")}
    path = f"{SERVER.parent}{os.pathsep}{os.environ['PATH']}"
    return {
        **folders,
        "HOME": str(home),
        "PATH": path,
        "BROWSER": str(home / "browser"),
        "DBUS_SESSION_BUS_ADDRESS": "disabled:",
    }


@contextmanager
def _screen() -> Iterator[str]:
    """Run an X server without a monitor, and yield its display."""
    reads, writes = os.pipe()
    command = [need("Xvfb"), "-displayfd", str(writes), "-screen", "0", "1280x800x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, pass_fds=[writes], stderr=subprocess.DEVNULL) as server:
        os.close(writes)
        try:
            with os.fdopen(reads) as numbers:
                yield f":{numbers.readline().strip()}"
        finally:
            server.terminate()


def _press(env: Mapping[str, str], *keys: str) -> None:
    """Press keys in Kate's window."""
    find = [need("xdotool"), "search", "--sync", "--onlyvisible", "--name", "dance.improv", "windowfocus", "--sync"]
    subprocess.run([*find, "key", *keys], env=dict(env), check=True, capture_output=True, timeout=LIMIT)
