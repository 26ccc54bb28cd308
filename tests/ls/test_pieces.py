"""An edit of a name that many lines use: what is near it is up to date at once, and the rest soon."""

from __future__ import annotations

from typing import Any

from improv_ls.documents import AT_ONCE
from tests.ls.client import Client

QUIET = {"onSave": "off"}
URI = "file:///dance.improv"
FIRST = {"start": {"line": 0, "character": 4}, "end": {"line": 0, "character": 11}}
PROGRAM = "x = forward\nr $ reverse x\n" + "r $ x\n" * (3 * AT_ONCE) + "r $ reverse x\n"
LAST = 3 * AT_ONCE + 2
EARLY, ALL = [1], [1, LAST]
"""The lines with errors once `x` never ends."""
SHOWS = {
    "textDocument": {"diagnostic": {}},
    "workspace": {"diagnostics": {"refreshSupport": True}, "inlayHint": {"refreshSupport": True}},
}


def lines(diagnostics: list[dict[str, Any]]) -> list[int]:
    """The lines with errors."""
    return [each["range"]["start"]["line"] for each in diagnostics if each["code"] == "endless-reverse"]


def published(client: Client, version: int) -> list[int]:
    """The lines with errors, as they are published next for a version."""
    sent = client.wait("textDocument/publishDiagnostics", lambda params: params["version"] == version)
    return lines(sent["diagnostics"])


def edited(client: Client) -> None:
    client.open(URI, PROGRAM)
    client.change(URI, 2, {"range": FIRST, "text": "repeat left"})


def test_what_is_near_is_published_first() -> None:
    with Client(QUIET) as client:
        edited(client)
        assert [published(client, 2), published(client, 2)] == [EARLY, ALL]


def test_a_key_in_between_loses_nothing() -> None:
    with Client(QUIET) as client:
        edited(client)
        client.change(URI, 3, {"range": {**FIRST, "end": FIRST["start"]}, "text": "left "})
        while published(client, 3) != ALL:
            pass


def test_who_asks_for_diagnostics_is_told_to_ask_again() -> None:
    with Client(QUIET, capabilities=SHOWS) as client:
        edited(client)
        client.wait("workspace/diagnostic/refresh")
        client.wait("workspace/inlayHint/refresh")
        answer = client.request("textDocument/diagnostic", {"textDocument": {"uri": URI}})
        assert lines(answer["items"]) == ALL


def test_a_request_sees_everything_up_to_its_place() -> None:
    with Client(QUIET) as client:
        place = {"textDocument": {"uri": URI}, "position": {"line": LAST, "character": 12}}
        client.open(URI, PROGRAM)
        before = client.request("textDocument/hover", place)
        client.change(URI, 2, {"range": FIRST, "text": "repeat left"})
        at_once = client.request("textDocument/hover", place)
        assert published(client, 2) == EARLY
        assert at_once == client.request("textDocument/hover", place) != before
