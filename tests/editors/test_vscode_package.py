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
from tests.editors import colors
from tests.editors.editors import ROOT, find
from tests.editors.vscode.workbench import bundle, packaged
from tests.needs import need

FOLDER = ROOT / "editors" / "vscode"
LARGEST = 250_000
"""Bytes of all other files in the .vsix than the wheel, compressed."""
LARGEST_WHEEL = 1_500_000
"""Bytes of the wheel, which grows with Improv."""
CONTENTS = {
    "LICENSE.txt",
    "dist/browser.js",
    "dist/extension.js",
    "icons/dark.svg",
    "icons/improv.png",
    "icons/light.svg",
    "language-configuration.json",
    "package.json",
    "readme.md",
    "snippets/improv.json",
    "syntaxes/improv-robots.tmLanguage.json",
    "syntaxes/improv.tmLanguage.json",
    "toml-configuration.json",
    "walkthrough/change.svg",
    "walkthrough/play.svg",
    "walkthrough/stop.svg",
    "walkthrough/write.svg",
    f"wheel/improv_ls-{__version__}-py3-none-any.whl",
}


@pytest.mark.slow("builds the extension")
def test_the_package_is_small_and_has_what_is_needed() -> None:
    files = zipfile.ZipFile(packaged()).infolist()
    assert {
        file.filename.removeprefix("extension/") for file in files if file.filename.startswith("extension/")
    } == CONTENTS
    wheels = [file.compress_size for file in files if file.filename.endswith(".whl")]
    assert sum(wheels) < LARGEST_WHEEL
    assert sum(file.compress_size for file in files) - sum(wheels) < LARGEST


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


def test_parts_without_a_window(tmp_path: Path) -> None:
    scripts = sorted((Path(__file__).parent / "vscode").glob("*.test.mjs"))
    bundle(tmp_path, *scripts)
    bundled = [str(tmp_path / script.name) for script in scripts]
    ran = subprocess.run([need("node"), "--test", *bundled], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout
    assert "# pass 23" in ran.stdout


def test_colors_before_the_server_answers(tmp_path: Path) -> None:
    entry = Path(find("CODE_SERVER", "code-server/node_modules/code-server/out/node/entry.js"))
    grammar, program = FOLDER / "syntaxes" / "improv.tmLanguage.json", tmp_path / "colors.improv"
    program.write_text(colors.PROGRAM)
    script = ROOT / "tests" / "editors" / "vscode" / "colors.mjs"
    command = [need("node"), script, entry.parents[2] / "lib" / "vscode", grammar, program]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    scopes = {
        "beat": "keyword.other.beat",
        "scene": "keyword.operator.scene",
        "title": "entity.name.section.scene",
        "opening": "keyword.other.opening",
        "choice": "constant.language.opening",
        "profile": "constant.language.opening",
        "primitive": "support.function.primitive",
        "transformer": "keyword.control.transformer",
        "conditional": "keyword.control.conditional",
        "plane": "constant.language.plane",
        "name": "variable.other.definition",
        "parameter": "variable.parameter",
        "robot": "entity.name.type.robot",
        "number": "constant.numeric",
        "operator": "keyword.operator",
        "comment": "comment.line.number-sign",
    }
    found = [[word, scope.removesuffix(".improv")] for word, scope in json.loads(done.stdout)]
    brackets = {"(", ")", "[", "]"}
    assert [[word, "variable.other" if word in brackets else scope] for word, scope in found] == colors.expected(
        scopes, plain="variable.other"
    )
