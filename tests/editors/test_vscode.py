"""A real VS Code, from the npm package code-server, in Chromium: what a person sees, and the robot that moves."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.request import urlopen

import pytest
from playwright.sync_api import Locator, Page, expect, sync_playwright

from tests.editors.editors import LIMIT, ROOT, find, nothing_left, started_from
from tests.needs import need

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]
FLAGS += ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"
PATIENCE = 60.0
"""Seconds that anything on the screen may take to come."""


@pytest.mark.timeout(2 * LIMIT)
def test_session(tmp_path: Path) -> None:
    code_server = find("CODE_SERVER", "code-server/node_modules/code-server/out/node/entry.js")
    work, user = tmp_path / "work", tmp_path / "user"
    work.mkdir()
    (work / "dance.improv").write_text(PROGRAM)
    (user / "User").mkdir(parents=True)
    settings = {"improv.server.path": str(Path(sys.executable).with_name("improv-ls")), "improv.backend": "sim"}
    (user / "User" / "settings.json").write_text(json.dumps(settings))
    with nothing_left() as env, _vscode(code_server, tmp_path, work, env) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need("chromium"), args=FLAGS)
        page = browser.new_page()
        page.set_default_timeout(PATIENCE * 1000)
        expect.set_options(timeout=PATIENCE * 1000)
        page.add_init_script("window.opened = []; window.open = address => { opened.push(address); return window }")
        page.goto(f"{address}/?folder={work}")
        _session(page, env)
        browser.close()


def _session(page: Page, env: Mapping[str, str]) -> None:
    page.get_by_role("treeitem", name="dance.improv").dblclick()
    expect(page.locator(".squiggly-error")).to_have_count(1)

    colors = {name: _color(_word(page, name)) for name in ("beat", "120", "turtle1", "repeat", "forward", "lft")}
    assert len(set(colors.values())) == len(colors), colors

    _word(page, "forward").hover()
    expect(page.locator(".monaco-hover:visible")).to_contain_text("1 beat, 0.50 s at beat 120")
    page.keyboard.press("Escape")

    _word(page, "lft").dblclick()
    page.keyboard.type("left")
    expect(page.locator(".squiggly-error")).to_have_count(0)
    page.keyboard.press("Control+S")
    toast = page.locator(".notification-toast")
    expect(toast).to_contain_text("▶ turtle1 ∞, endless at beat 120, simulator")
    expect(page.locator(".statusbar")).to_contain_text(re.compile(r"beat \d+/∞"))

    # code-server sends the browser to a proxy, and drops the token on the way.
    page.wait_for_function("opened.length > 0")
    port = re.findall(r"proxy/(\d+)", page.evaluate("opened[0]"))[0]
    token = next(its["IMPROV_PAGE_TOKEN"] for its in started_from(env).values() if "IMPROV_PAGE_TOKEN" in its)
    url = f"http://127.0.0.1:{port}/?token={token}"
    _robot(url, "moves")
    _run_command(page, "Improv: Stop the robots")
    _robot(url, "stands")
    _run_command(page, "Improv: Play")
    _robot(url, "moves")


def _word(page: Page, text: str) -> Locator:
    return page.locator(".view-line span:not(:has(span))").get_by_text(re.compile(rf"^\s*{text}\s*$"))


def _color(word: Locator) -> str:
    return str(word.evaluate("element => getComputedStyle(element).color"))


def _run_command(page: Page, title: str) -> None:
    page.keyboard.press("F1")
    page.keyboard.type(title)
    page.locator(".quick-input-list .monaco-list-row", has_text=title.split(": ")[1]).first.click()


def _robot(url: str, does: str) -> None:
    # A process of its own: playwright's event loop runs in this one.
    subprocess.run([sys.executable, "-m", "tests.editors.robot", url, does], cwd=ROOT, check=True)


@contextmanager
def _vscode(code_server: str, folder: Path, work: Path, env: Mapping[str, str]) -> Iterator[str]:
    """code-server with our extension; its address."""
    package = [need("npm"), "run", "package", "--", "--out", str(folder / "improv.vsix")]
    subprocess.run(package, cwd=ROOT / "editors" / "vscode", check=True, capture_output=True)
    (folder / "config.yaml").touch()
    command = [need("node"), code_server, "--config", str(folder / "config.yaml")]
    command += ["--user-data-dir", str(folder / "user"), "--extensions-dir", str(folder / "extensions")]
    command += ["--disable-telemetry", "--disable-update-check"]
    subprocess.run([*command, "--install-extension", str(folder / "improv.vsix")], check=True, capture_output=True)

    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"127.0.0.1:{free.getsockname()[1]}"
    command += ["--bind-addr", address, "--auth", "none", "--disable-workspace-trust"]
    with (folder / "log").open("wb") as log:
        server = subprocess.Popen([*command, str(work)], env=env, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
    try:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with suppress(OSError), urlopen(f"http://{address}/healthz"):
                break
            time.sleep(0.1)
        yield f"http://{address}"
    finally:
        server.terminate()
        server.wait(PATIENCE)
