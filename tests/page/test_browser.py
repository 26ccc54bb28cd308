"""Browsers that may show the page."""

from __future__ import annotations

from pathlib import Path

import pytest

from improv_core.page.browser import has_browser
from tests.commands.command_line import run


@pytest.mark.parametrize(
    ("environment", "found"), [({}, False), ({"DISPLAY": ":0"}, True), ({"BROWSER": "/bin/true %s"}, True)]
)
@pytest.mark.skipif("sys.platform != 'linux'", reason="other systems always have a screen")
def test_without_a_screen_only_a_browser_that_is_named(
    environment: dict[str, str], found: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("webbrowser.get", object)
    assert has_browser() is found


@pytest.mark.skipif("sys.platform != 'linux'", reason="other systems always have a screen")
def test_no_text_browser_takes_over_the_terminal(tmp_path: Path) -> None:
    browser, opened = tmp_path / "w3m", tmp_path / "opened"
    browser.write_text(f"#!/bin/sh\n: > {opened}\n")
    browser.chmod(0o755)
    (tmp_path / "dance.improv").write_text("beat 600\nr $ forward\n")
    env = {"PATH": f"{tmp_path}", "DISPLAY": "", "WAYLAND_DISPLAY": "", "BROWSER": "", "TERM": "xterm"}
    done = run("play", "--backend", "sim", tmp_path / "dance.improv", env=env)
    assert (done.returncode, opened.exists()) == (0, False)
    assert done.stdout.startswith("watch it at http://")
