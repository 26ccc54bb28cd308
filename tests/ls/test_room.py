"""Meetings of robots in an editor: shown a moment after the other diagnostics."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from improv_core.ipc.asking import Answerer
from improv_ls.room_checker import Sight
from tests.ls.client import LIMIT, Client
from tests.ls.test_diagnostics_pull import PULLS, QUIET, pull

URI = "file:///dance.improv"
PROGRAM = "ada at 0 0\nbo at 1 -1 facing 90\nada $ forward\nbo $ forward\n"
METHOD = "textDocument/publishDiagnostics"


def codes(params: Any) -> list[str]:
    return [each["code"] for each in params["diagnostics"]]


def test_meetings_follow_the_other_diagnostics() -> None:
    with Client(QUIET) as client:
        client.open(URI, f"{PROGRAM}x = left\n")
        assert codes(client.wait(METHOD)) == ["unused-name"]
        found = client.wait(METHOD, lambda params: "meets" in codes(params))
        assert codes(found) == ["meets", "unused-name"]
        assert found["version"] == 1


def test_meetings_in_a_text_are_dropped_with_the_next_key() -> None:
    with Client(QUIET) as client:
        client.open(URI, PROGRAM)
        client.wait(METHOD, lambda params: codes(params) == ["meets"])
        client.change(URI, 2, {"text": PROGRAM.replace("1 -1", "5 -1")})
        assert codes(client.wait(METHOD, lambda params: params["version"] == 2)) == []
        client.change(URI, 3, {"text": PROGRAM})
        assert codes(client.wait(METHOD, lambda params: params["version"] == 3)) == []
        assert client.wait(METHOD, lambda params: codes(params) == ["meets"])["version"] == 3


def test_an_editor_that_asks_for_diagnostics_is_told_to_ask_again(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = threading.Event()
    with Client(QUIET, capabilities=PULLS) as client, monkeypatch.context() as patch:
        check = Answerer.ask
        patch.setattr(Answerer, "ask", lambda *program: check(*program) if asked.wait(LIMIT) else Sight())
        client.open(URI, PROGRAM)
        first = pull(client, URI)
        assert first["items"] == []
        asked.set()
        client.wait("workspace/diagnostic/refresh")
        again = pull(client, URI, first["resultId"])
        assert codes({"diagnostics": again["items"]}) == ["meets"]
        assert again["items"][0]["relatedInformation"][0]["message"] == "`ada` does this then"
