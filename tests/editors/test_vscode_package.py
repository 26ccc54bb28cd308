"""The contents of VS Code's extension, and the parts of it that need no window."""

from __future__ import annotations

import json
import re
import subprocess
import zipfile
from pathlib import Path

import pytest

from improv_core import __version__
from improv_ls.server import create_server
from tests.editors.editors import ROOT
from tests.editors.vscode.workbench import packaged
from tests.needs import need

FOLDER = ROOT / "editors" / "vscode"
LARGEST = 1_000_000
"""Bytes of the .vsix."""
CONTENTS = {
    "LICENSE.txt",
    "dist/extension.js",
    "icons/dark.svg",
    "icons/improv.png",
    "icons/light.svg",
    "language-configuration.json",
    "package.json",
    "readme.md",
    "snippets/improv.json",
    "syntaxes/improv.tmLanguage.json",
    "walkthrough/change.svg",
    "walkthrough/play.svg",
    "walkthrough/stop.svg",
    "walkthrough/write.svg",
    f"wheel/improv_ls-{__version__}-py3-none-any.whl",
}


def test_the_package_is_small_and_has_what_is_needed() -> None:
    package = packaged()
    assert package.stat().st_size < LARGEST
    names = set(zipfile.ZipFile(package).namelist())
    assert {name.removeprefix("extension/") for name in names if name.startswith("extension/")} == CONTENTS


def test_the_version_is_improvs() -> None:
    assert f'"version": "{__version__}"' in (FOLDER / "package.json").read_text(encoding="utf-8")


def test_commands_are_the_extensions_or_the_servers_and_never_both() -> None:
    servers = set(create_server().protocol.fm.commands)
    own = set(re.findall(r'^    "(improv\.\w+)":', (FOLDER / "src" / "commands.ts").read_text(encoding="utf-8"), re.M))
    contributes = json.loads((FOLDER / "package.json").read_text(encoding="utf-8"))["contributes"]
    assert own
    assert not servers & own
    assert {each["command"] for each in contributes["commands"] + contributes["keybindings"]} <= servers | own


def test_every_notification_goes_through_the_function_that_removes_links() -> None:
    users = {path.name for path in (FOLDER / "src").iterdir() if "Message(" in path.read_text(encoding="utf-8")}
    assert users == {"messages.ts"}


def test_the_lock_file_names_no_place_to_get_packages_from() -> None:
    assert '"resolved"' not in (FOLDER / "package-lock.json").read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "passes"), [("messages", 8), ("moments", 5), ("transport", 2), ("words", 7)])
def test_parts_without_a_window(tmp_path: Path, name: str, passes: int) -> None:
    packaged()  # brings esbuild, if it is not there
    tests, bundled = Path(__file__).parent / "vscode", tmp_path / "test.mjs"
    bundle = ["node_modules/.bin/esbuild", str(tests / f"{name}.test.mjs"), f"--outfile={bundled}", "--bundle"]
    bundle += ["--platform=node", "--format=esm", f"--alias:vscode={tests / 'vscode.mjs'}"]
    subprocess.run(bundle, cwd=FOLDER, check=True, capture_output=True)
    ran = subprocess.run([need("node"), "--test", str(bundled)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout
    assert f"# pass {passes}" in ran.stdout
