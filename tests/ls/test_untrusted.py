"""No text in a program, improv.toml, or the settings can control the editor that shows it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings

from tests.commands.test_untrusted import PROGRAM, TOML, quoted
from tests.ls.client import Client, place
from tests.untrusted import EXPLOITS, FOREIGN, steering

QUIET = {"backend": "sim", "onSave": "off", "page": {"open": False}}
HOVERS = {
    "textDocument": {
        "hover": {"contentFormat": ["markdown"]},
        "publishDiagnostics": {"relatedInformation": True},
        "codeAction": {"codeActionLiteralSupport": {"codeActionKind": {"valueSet": ["quickfix"]}}},
    }
}
EXACT = {"newText", "uri"}
"""Fields that nobody sees, and that must stay as they are."""


def shown(value: Any) -> Iterator[str]:
    """Yield every text in a message that may be shown."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for each in value:
            yield from shown(each)
    elif isinstance(value, dict):
        for key, each in value.items():
            if key not in EXACT:
                yield from shown(each)


def use(client: Client, folder: Path, word: str, key: str, numbers: Iterator[int]) -> None:
    """Have the server send every message that it can about a program and its improv.toml."""
    (folder / "improv.toml").write_text(TOML.format(quoted(key)), encoding="utf-8")
    uri = (folder / f"dance{next(numbers)}.improv").as_uri()
    text = PROGRAM.format(word)
    document = {"textDocument": {"uri": uri}}
    client.open(uri, text)
    lines = re.split("\r\n|\r|\n", text)
    for number, line in enumerate(lines):
        for column in {0, len(line.encode("utf-16-le")) // 4, line.find("$"), line.find("=")} - {-1}:
            client.request("textDocument/hover", place(uri, number, column))
    client.request("textDocument/documentSymbol", document)
    client.request("textDocument/codeLens", document)
    everything = {"start": {"line": 0, "character": 0}, "end": {"line": len(lines), "character": 0}}
    client.request("textDocument/codeAction", {**document, "range": everything, "context": {"diagnostics": []}})
    client.notify("textDocument/didClose", document)


@pytest.mark.slow("tries many inputs")
def test_no_input_reaches_the_editor_unescaped(tmp_path: Path) -> None:
    numbers = count()
    with Client(QUIET, capabilities=HOVERS) as client:

        @given(FOREIGN, FOREIGN)
        @settings(suppress_health_check=[HealthCheck.differing_executors])
        def check(word: str, key: str) -> None:
            client.log.clear()
            use(client, tmp_path, word.encode(errors="replace").decode(), key, numbers)
            said = [text for each in client.log if each.by_server for text in shown(each.message)]
            assert said
            assert set().union(*map(steering, said)) == set()

        check()


def test_a_setting_is_echoed_literally() -> None:
    with Client(QUIET, capabilities={}) as client:
        for exploit in EXPLOITS.values():
            client.set(backend=exploit)
            line = client.wait_for_line("improv.backend: expected")
            assert steering(line, "") == set()
            assert "](" not in line
            assert len(line) < 500


@pytest.mark.parametrize("exploit", ["link", "image", "code"])
def test_a_hover_has_no_links_from_the_files(tmp_path: Path, exploit: str) -> None:
    (tmp_path / "improv.toml").write_text(
        "[robots.r]\nprofile = {0}\n[profiles.{0}]\nstep = 1\n".format(quoted(EXPLOITS[exploit]))
    )
    uri = (tmp_path / "dance.improv").as_uri()
    with Client(QUIET, capabilities=HOVERS) as client:
        client.open(uri, "r $ forward\n")
        markdown = client.request("textDocument/hover", place(uri, 0, 0))["contents"]["value"]
    code = re.search("profile (`[^`]*`)", markdown)
    assert code, markdown
    assert "](" not in markdown.replace(code[1], "")
