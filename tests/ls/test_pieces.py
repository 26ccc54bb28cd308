"""An edit of a name that many lines use: nearby lines are up to date at once, and the rest soon."""

from __future__ import annotations

from typing import Any

import pytest

from improv_ls import settling
from tests.ls.client import LIMIT, Client, place, span

MANY = 3_000
QUIET = {"onSave": "off"}
URI = "file:///dance.improv"
FIRST = span(0, 4, 11)
PROGRAM = "x = forward\nr $ reverse x\n" + "r $ x\n" * MANY + "r $ reverse x\n"
LAST = MANY + 2
EARLY, ALL = [1], [1, LAST]
"""Lines with errors once `x` never ends."""
SHOWS = {
    "textDocument": {"diagnostic": {}},
    "workspace": {"diagnostics": {"refreshSupport": True}, "inlayHint": {"refreshSupport": True}},
}


def lines(diagnostics: list[dict[str, Any]]) -> list[int]:
    """Return the lines with errors."""
    return [each["range"]["start"]["line"] for each in diagnostics if each["code"] == "endless-reverse"]


def published(client: Client, version: int) -> list[int]:
    """Wait for the lines with errors that are published next for a version."""
    sent = client.wait("textDocument/publishDiagnostics", lambda params: params["version"] == version)
    return lines(sent["diagnostics"])


def edited(client: Client) -> None:
    opened(client)
    client.change(URI, 2, {"range": FIRST, "text": "repeat left"})


def opened(client: Client) -> None:
    """Open the program, and wait until all of it is analyzed: a rename needs that."""
    client.open(URI, PROGRAM)
    client.request("textDocument/rename", place(URI, 0, 0, newName="y"))


def test_diagnostics_near_the_edit_are_published_first() -> None:
    with Client(QUIET, hurries=True) as client:
        edited(client)
        shown = [published(client, 2)]
        while shown[-1] != ALL:  # on a busy machine, in more pieces
            shown.append(published(client, 2))
        assert [lines for lines in shown if lines not in ([], EARLY)] == [ALL]


def test_a_client_that_asks_before_all_is_known_asks_again_once_it_is() -> None:
    with Client(QUIET, capabilities=SHOWS, hurries=True) as client:
        edited(client)
        pulled = {"textDocument": {"uri": URI}}
        while lines(client.request("textDocument/diagnostic", pulled)["items"]) != ALL:
            client.wait("workspace/diagnostic/refresh")
            client.wait("workspace/inlayHint/refresh")


def test_a_client_that_asks_once_all_is_known_need_not_ask_again() -> None:
    with Client(QUIET, capabilities=SHOWS, hurries=True) as client:
        edited(client)
        client.request("textDocument/rename", place(URI, 0, 0, newName="y"))
        assert lines(client.request("textDocument/diagnostic", {"textDocument": {"uri": URI}})["items"]) == ALL
        assert not [each for each in client.log if str(each.message.get("method")).endswith("/refresh")]


@pytest.mark.slow("analyzes thousands of lines twice")
def test_a_request_sees_everything_above_its_position(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settling, "PATIENCE", LIMIT)  # a busy machine needs longer
    with Client(QUIET, hurries=True) as client:
        opened(client)
        last = place(URI, LAST, 2)
        before = client.request("textDocument/hover", last)
        client.change(URI, 2, {"range": FIRST, "text": "repeat left"})
        at_once = client.request("textDocument/hover", last)
        assert at_once == client.request("textDocument/hover", last) != before
