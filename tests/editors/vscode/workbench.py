"""A real VS Code, from the npm package code-server, in Chromium, with our extension as people get it."""

from __future__ import annotations

import fcntl
import json
import os
import re
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.request import urlopen

from playwright.sync_api import FrameLocator, Locator, Page, expect, sync_playwright

from tests.editors.editors import ROOT, find, program_of, started_from
from tests.needs import EXTENSION as FOLDER
from tests.needs import need, need_extension
from tests.open_page import CALMLY
from tests.processes import command_of
from tests.waiting import until

HERE = Path(__file__).parent
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]
FLAGS += ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
QUIET = {
    "files.autoSave": "off",  # as on the desktop. In a browser, VS Code saves a second after the last key by itself
    "security.workspace.trust.startupPrompt": "never",
    "security.workspace.trust.banner": "never",
    "workbench.reduceMotion": "on",
    "workbench.startupEditor": "none",
    "workbench.tips.enabled": False,
}
PATIENCE = 60.0
"""Seconds until an expected element must be on the screen."""


@cache
def packaged() -> Path:
    """Return the extension as a .vsix, made again if its sources have changed. No two processes make it at once."""
    need_extension()
    package, made_of = FOLDER / "improv.vsix", FOLDER / "dist" / "made-of"
    with _alone():
        if not (package.exists() and made_of.exists() and made_of.read_text() == _hash_of_sources()):
            env = {**os.environ, "PYTHON": sys.executable}
            made = subprocess.run([need("npm"), "run", "package"], cwd=FOLDER, env=env, capture_output=True, text=True)
            assert made.returncode == 0, made.stdout + made.stderr
            made_of.write_text(_hash_of_sources())
    return package


def bundle(folder: Path, *scripts: Path) -> None:
    """Bundle scripts that import parts of the extension, each into a file in this folder that node runs."""
    need_extension()
    options = ["--bundle", "--platform=node", "--format=esm", "--out-extension:.js=.mjs", f"--outdir={folder}"]
    command = ["node_modules/.bin/esbuild", *map(str, scripts), *options, f"--alias:vscode={HERE / 'vscode.mjs'}"]
    subprocess.run(command, cwd=FOLDER, check=True, capture_output=True)


@contextmanager
def _alone() -> Iterator[None]:
    """Keep other processes out: tests run side by side, and all build in one folder."""
    with (FOLDER / "package.json").open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _hash_of_sources() -> str:
    """Return a hash of all sources of the extension and of its wheel."""
    made = {"node_modules", "dist", "wheel", "__pycache__"}
    own = [
        "editors/vscode",
        "improv_core",
        "improv_ls",
        "docs/diagnostics.md",
        "pyproject.toml",
        "README.md",
        "LICENSE",
    ]
    total = sha256()
    for path in sorted(path for each in own for path in (ROOT / each, *(ROOT / each).rglob("*"))):
        if path.is_file() and not made.intersection(path.relative_to(ROOT).parts) and path.suffix != ".vsix":
            total.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes())
    return total.hexdigest()


@dataclass(frozen=True, slots=True)
class VSCode:
    """A VS Code that several tests use in turn: starting it and a browser takes as long as opening a window."""

    folder: Path
    env: Mapping[str, str]
    address: str
    page: Page

    @contextmanager
    def window(
        self,
        work: Path,
        program: str,
        settings: Mapping[str, object],
        workspace_settings: Mapping[str, object] | None = None,
    ) -> Iterator[Page]:
        """Open `dance.improv` in a window on this folder, which is not trusted yet. All processes started from it must
        end once the window is closed."""
        try:
            with opened(self.page, self.address, self.folder, work, program, settings, workspace_settings or {}):
                yield self.page
        finally:
            self.page.goto("about:blank")
            until(lambda: not self._others(), lambda: f"still run: {[command_of(pid) for pid in self._others()]}")

    def set_machine_settings(self, settings: Mapping[str, object]) -> None:
        """Set values that only the machine's settings may have, such as the server's path; an open window follows."""
        _write_settings(self.folder / "user" / "Machine", settings)

    def _others(self) -> list[int]:
        """Return all processes that have been started from it, without its own."""
        return [pid for pid in started_from(self.env) if program_of(pid) not in ("node", "")]


@contextmanager
def vscode(folder: Path, env: Mapping[str, str]) -> Iterator[VSCode]:
    """Start a VS Code without a window."""
    with code_server(folder, env) as address, _browser() as page:
        yield VSCode(folder, env, address, page)


@contextmanager
def _browser() -> Iterator[Page]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 800}, color_scheme="null")
        page.set_default_timeout(PATIENCE * 1000)
        expect.set_options(timeout=PATIENCE * 1000)
        page.add_init_script(f"if (location.pathname.startsWith('/proxy/')) {CALMLY}")
        yield page
        browser.close()


@contextmanager
def opened(
    page: Page,
    address: str,
    folder: Path,
    work: Path,
    program: str,
    settings: Mapping[str, object],
    workspace_settings: Mapping[str, object],
) -> Iterator[None]:
    _write_settings(folder / "user" / "User", {**QUIET, **settings})
    of_machine = {name: value for name, value in settings.items() if name.startswith("improv.")}
    _write_settings(folder / "user" / "Machine", of_machine)
    _write_settings(work / ".vscode", workspace_settings)
    (work / "dance.improv").write_text(program)
    page.goto(f"{address}/?folder={work}")
    page.get_by_role("treeitem", name="dance.improv").dblclick()
    try:
        yield
    except BaseException:
        keep_picture(page, "failed")
        raise


def word(page: Page, text: str) -> Locator:
    """Return a word of the program on the screen."""
    return page.locator(".view-line span:not(:has(span))").get_by_text(re.compile(rf"^\s*{text}\s*$"))


def run_command(page: Page, title: str) -> None:
    """Choose a command from the palette."""
    page.keyboard.press("F1")
    expect(page.locator(".quick-input-widget input[type=text]")).to_be_focused()
    page.keyboard.insert_text(title)  # at once: it would look for commands again after each letter
    page.locator(".quick-input-list .monaco-list-row", has_text=title.split(": ")[1]).first.click()


def framed_page(page: Page) -> FrameLocator:
    """Return the page with the robots, in the panel beside the text."""
    return framed(page).frame_locator("iframe")


def framed(page: Page) -> FrameLocator:
    """Return the contents of an extension's panel."""
    return page.frame_locator("iframe.webview.ready").frame_locator("iframe#active-frame")


def keep_picture(page: Page, name: str) -> None:
    """Save a picture of the window in the folder that the environment names, if any."""
    if folder := os.environ.get("IMPROV_ARTIFACTS"):
        Path(folder).mkdir(parents=True, exist_ok=True)
        page.screenshot(path=Path(folder) / f"{name}.png")


def _write_settings(folder: Path, settings: Mapping[str, object]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "settings.json").write_text(json.dumps(settings))


@cache
def installed() -> TemporaryDirectory[str]:
    """Return a folder of extensions with ours installed, made once for all tests."""
    extensions = TemporaryDirectory(prefix="improv-extensions-")
    with TemporaryDirectory() as folder:
        command = [*_code_server_with(Path(folder)), "--user-data-dir", folder, "--extensions-dir", extensions.name]
        subprocess.run([*command, "--install-extension", str(packaged())], check=True, capture_output=True)
    return extensions


def _code_server_with(folder: Path) -> list[str]:
    """Return the command that runs code-server with an empty configuration in this folder."""
    code_server = find("CODE_SERVER", "code-server/node_modules/code-server/out/node/entry.js")
    (folder / "config.yaml").touch()
    return [need("node"), code_server, "--config", str(folder / "config.yaml")]


@contextmanager
def code_server(folder: Path, env: Mapping[str, str]) -> Iterator[str]:
    """Run a code-server with our extension, and yield its address."""
    command = _code_server_with(folder)
    command += ["--user-data-dir", str(folder / "user"), "--extensions-dir", str(folder / "extensions")]
    command += ["--disable-telemetry", "--disable-update-check"]
    shutil.copytree(installed().name, folder / "extensions")

    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"127.0.0.1:{free.getsockname()[1]}"
    command += ["--bind-addr", address, "--auth", "none"]
    with (folder / "log").open("wb") as log:
        server = subprocess.Popen(command, env=env, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    try:
        until(lambda: _answers(address), (folder / "log").read_text)
        yield f"http://{address}"
    finally:
        server.terminate()
        server.wait(PATIENCE)


def _answers(address: str) -> bool:
    with suppress(OSError), urlopen(f"http://{address}/healthz"):
        return True
    return False
