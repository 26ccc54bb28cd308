"""Record the `initialize` of real editors: `python -m tests.ls.clients.record [NAME]...`, the names as in EDITORS.

Each editor is started with the files of editors/ and opens a program. As its language server it gets this file, which
notes the `initialize` that comes. `.cache/` has the editors: tests/editors/fetch.sh gets them.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.editors.editors import LIMIT, ROOT, find
from tests.needs import need

HOME = "/home/person"
"""The name in a record of the folder above the program's."""


@dataclass(frozen=True, slots=True)
class Setting:
    """Files for an editor: the program to open, the stand-in for the server, and its notes."""

    folder: Path
    program: Path
    server: Path
    noted: Path


def main() -> None:
    for name in sys.argv[1:] or EDITORS:
        with TemporaryDirectory() as folder:
            _record(name, _setting(Path(folder)))


def _setting(folder: Path) -> Setting:
    setting = Setting(folder, folder / "dances" / "dance.improv", folder / "bin" / "improv-ls", folder / "noted")
    setting.program.parent.mkdir()
    setting.program.write_text("turtle1 $ forward\n")
    setting.server.parent.mkdir()
    note = f"{sys.executable} -m {__spec__.name} --note {setting.noted}"
    setting.server.write_text(f"#!/bin/sh\ncd {ROOT}\nexec {note}\n")
    setting.server.chmod(0o755)
    return setting


def _record(name: str, setting: Setting) -> None:
    EDITORS[name](setting)
    params = json.loads(setting.noted.read_text(encoding="utf-8"))
    record = {"source": "recorded", "initialize": {**params, "processId": None}}
    text = json.dumps(record, indent=1, ensure_ascii=False, sort_keys=True).replace(str(setting.folder), HOME)
    Path(__file__).with_name(f"{name}.json").write_text(f"{text}\n", encoding="utf-8")


def _note(noted: Path) -> None:
    """Be a language server that ends after the first message."""
    stream = sys.stdin.buffer
    length = 0
    while line := stream.readline().strip():
        if found := re.match(rb"(?i)content-length: *(\d+)", line):
            length = int(found[1])
    new = noted.with_suffix(".new")
    new.write_text(json.dumps(json.loads(stream.read(length))["params"]), encoding="utf-8")
    new.rename(noted)


def _neovim(variable: str, fetched: str) -> Callable[[Setting], None]:
    def start(setting: Setting) -> None:
        init = setting.folder / "init.lua"
        init.write_text(
            'vim.opt.runtimepath:prepend(vim.env.IMPROV_PLUGIN)\nrequire("improv").setup { cmd = { "improv-ls" } }\n'
        )
        command = [find(variable, f"{fetched}/usr/bin/nvim"), "--headless", "-i", "NONE", "-n", "-u", str(init)]
        _run([*command, str(setting.program)], setting, {"IMPROV_PLUGIN": str(ROOT / "editors" / "neovim")})

    return start


def _helix(setting: Setting) -> None:
    languages = setting.folder / "helix" / "languages.toml"
    languages.parent.mkdir()
    languages.write_text((ROOT / "editors" / "helix" / "languages.toml").read_text(encoding="utf-8"))
    # Helix needs a terminal; `script` is one.
    command = [find("HELIX", "helix/usr/bin/hx"), str(setting.program)]
    _run(["script", "-qec", " ".join(command), "/dev/null"], setting, {"TERM": "xterm", "LANG": "C.UTF-8"})


def _emacs(setting: Setting) -> None:
    init = setting.folder / "init.el"
    init.write_text(
        "(setq native-comp-enable-subr-trampolines nil native-comp-jit-compilation nil)\n"
        "(require 'improv-mode)\n"
        "(find-file (car command-line-args-left))\n"
        "(eglot-ensure)\n"
        "(run-hooks 'post-command-hook)\n"
        "(while t (accept-process-output nil 1))\n"
    )
    command = [find("EMACS", "emacs/usr/bin/emacs"), "-Q", "--batch", "-L", str(ROOT / "editors" / "emacs")]
    _run([*command, "-l", str(init), str(setting.program)], setting, {"HOME": str(setting.folder)})


def _kate(setting: Setting) -> None:
    """Start the Kate of Debian 12."""
    kate = ROOT / "editors" / "kate"
    for file, place in (
        (kate / "improv.xml", ".local/share/org.kde.syntax-highlighting/syntax"),
        (kate / "settings.json", ".config/kate/lspclient"),
    ):
        (setting.folder / place).mkdir(parents=True)
        (setting.folder / place / file.name).write_bytes(file.read_bytes())
    # As if it had asked for permission to start the server.
    (setting.folder / ".config" / "katerc").write_text(f"[lspclient]\nAllowedServerCommandLines={setting.server}\n")
    env = {"HOME": str(setting.folder), "QT_QPA_PLATFORM": "offscreen", "DBUS_SESSION_BUS_ADDRESS": "disabled:"}
    places = {"XDG_CONFIG_HOME": str(setting.folder / ".config"), "XDG_DATA_HOME": str(setting.folder / ".local/share")}
    _run([need("kate"), str(setting.program)], setting, {**env, **places})


def _vscode(setting: Setting) -> None:
    """Start VS Code itself, in a browser."""
    from tests.editors.vscode.workbench import workbench

    settings = {"improv.server.path": str(setting.server), "security.workspace.trust.enabled": False}
    with workbench(setting.folder / "vscode", "turtle1 $ forward\n", settings, os.environ):
        _wait(setting)


def _run(command: list[str], setting: Setting, env: Mapping[str, str]) -> None:
    """Run the editor until it has sent its name."""
    places = {f"XDG_{kind}_HOME": str(setting.folder) for kind in ("CONFIG", "DATA", "STATE", "CACHE")}
    path = f"{setting.server.parent}:{os.environ['PATH']}"
    editor = subprocess.Popen(
        command,
        cwd=setting.program.parent,
        env={**os.environ, **places, "PATH": path, **env},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        _wait(setting)
    finally:
        editor.kill()
        editor.wait()


def _wait(setting: Setting) -> None:
    end = time.monotonic() + LIMIT
    while not setting.noted.exists():
        if time.monotonic() > end:
            sys.exit(f"the editor started no language server within {LIMIT:g} s")
        time.sleep(0.05)


EDITORS: Mapping[str, Callable[[Setting], Any]] = {
    "neovim-0.10": _neovim("NVIM", "nvim-0.10"),
    "neovim-0.12": _neovim("NVIM_0_12", "nvim-0.12"),
    "helix": _helix,
    "emacs": _emacs,
    "kate-22.12": _kate,
    "vscode": _vscode,
}

if __name__ == "__main__":
    if sys.argv[1:2] == ["--note"]:
        _note(Path(sys.argv[2]))
    else:
        main()
