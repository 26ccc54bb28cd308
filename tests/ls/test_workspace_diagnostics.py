"""Diagnostics of all programs in a folder, open or not, for editors that ask for them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.ls.client import Client

PULLS = {
    "textDocument": {"diagnostic": {}},
    "workspace": {
        "diagnostics": {"refreshSupport": True},
        "didChangeWatchedFiles": {"dynamicRegistration": True},
    },
}
UNWATCHED = {**PULLS, "workspace": {"diagnostics": {"refreshSupport": True}}}
Reports = Mapping[str, Mapping[str, Any]]


def pull(client: Client, before: Reports | None = None, **tokens: str) -> dict[str, Mapping[str, Any]]:
    """Return the reports by the names of their files."""
    known = [{"uri": each["uri"], "value": each["resultId"]} for each in (before or {}).values() if "resultId" in each]
    found = client.request("workspace/diagnostic", {"previousResultIds": known, **tokens})["items"]
    return by_name(found)


def by_name(reports: list[Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    return {each["uri"].rpartition("/")[2]: each for each in reports}


def codes(reports: Reports) -> dict[str, list[str] | str]:
    return {
        name: [item["code"] for item in each["items"]] if each["kind"] == "full" else each["kind"]
        for name, each in reports.items()
    }


def test_all_programs_in_a_folder_and_then_only_the_changed_ones(tmp_path: Path) -> None:
    a, b, c = (tmp_path / f"{name}.improv" for name in "abc")
    a.write_text("anna $ fowrard\n")
    b.write_text("anna $ left\n")
    c.write_text("x = left\n")
    with Client({"onSave": "off"}, capabilities=PULLS, folders=[tmp_path]) as client:
        client.open(b.as_uri(), "anna $ (left\n")
        first = pull(client)
        assert codes(first) == {
            "a.improv": ["unknown-name"],
            "b.improv": ["unclosed-bracket"],
            "c.improv": ["unused-name"],
        }
        assert (first["a.improv"]["version"], first["b.improv"]["version"]) == (None, 1)
        c.write_text("x = left # with the same diagnostic\n")
        assert codes(pull(client, first)) == dict.fromkeys(first, "unchanged")

        a.write_text("anna $ forward\n")
        c.unlink()
        client.change(b.as_uri(), 2, {"text": "anna $ left # as it was on disk\n"})
        second = pull(client, first)
        assert codes(second) == {"a.improv": [], "b.improv": [], "c.improv": []}
        assert codes(pull(client, second)) == {"a.improv": "unchanged", "b.improv": "unchanged"}

        (tmp_path / "improv.toml").write_text("[robots.bert]\n")
        client.notify("textDocument/didClose", {"textDocument": {"uri": b.as_uri()}})
        assert codes(pull(client, second)) == {"a.improv": ["unknown-robot"], "b.improv": ["unknown-robot"]}


def test_a_large_folder_is_sent_in_parts_and_shows_progress(tmp_path: Path) -> None:
    for number in range(25):
        (tmp_path / f"{number:02}.improv").write_text("anna $ fowrard\n")
    with Client({"onSave": "off"}, capabilities=UNWATCHED, folders=[tmp_path]) as client:
        assert pull(client, partialResultToken="part", workDoneToken="done") == {}
        told = [each["params"] for each in client.notifications if each["method"] == "$/progress"]
        parts = [by_name(each["value"]["items"]) for each in told if each["token"] == "part"]
        assert [len(part) for part in parts] == [10, 10, 5]
        assert [each for part in parts for each in codes(part).values()] == 25 * [["unknown-name"]]
        done = [each["value"] for each in told if each["token"] == "done"]
        assert [each["kind"] for each in done] == ["begin", "report", "report", "report", "end"]
        assert [each["percentage"] for each in done if "percentage" in each] == [0, 40, 80, 100]
        again = pull(client, {name: each for part in parts for name, each in part.items()})
        assert set(codes(again).values()) == {"unchanged"}


def test_a_client_that_watches_files_gets_changes(tmp_path: Path) -> None:
    a, b = (tmp_path / f"{name}.improv" for name in "ab")
    a.write_text("anna $ fowrard\n")
    b.write_text("anna $ left\n")
    with Client({"onSave": "off"}, capabilities=PULLS, folders=[tmp_path]) as client:
        client.begin("workspace/diagnostic", {"previousResultIds": [], "partialResultToken": "part"})

        def told() -> dict[str, list[str] | str]:
            return codes(by_name(client.wait("$/progress")["value"]["items"]))

        assert told() == {"a.improv": ["unknown-name"], "b.improv": []}
        b.write_text("anna $ (left\n")
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": b.as_uri(), "type": 2}]})
        assert told() == {"b.improv": ["unclosed-bracket"]}
        client.open(a.as_uri(), "anna $ forward\n")
        a.unlink()
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": a.as_uri(), "type": 3}]})
        client.notify("textDocument/didClose", {"textDocument": {"uri": a.as_uri()}})
        assert told() == {"a.improv": []}
        folder = {"uri": tmp_path.as_uri(), "name": tmp_path.name}
        client.notify("workspace/didChangeWorkspaceFolders", {"event": {"added": [], "removed": [folder]}})
        assert told() == {"b.improv": []}


@pytest.mark.slow("checks a large folder")
def test_typing_is_not_delayed_and_a_canceled_request_ends(tmp_path: Path) -> None:
    program = "".join(f"x{number} = left up right\n" for number in range(300))
    for number in range(150):
        (tmp_path / f"{number:02}.improv").write_text(program)
    with Client({"onSave": "off"}, capabilities=PULLS, folders=[tmp_path], hurries=True) as client:
        uri = (tmp_path / "00.improv").as_uri()
        client.open(uri, "anna $ left\n")
        asked = client.begin("workspace/diagnostic", {"previousResultIds": [], "partialResultToken": "part"})
        client.wait("$/progress")
        client.change(uri, 2, {"text": "anna $ fowrard\n"})
        items = client.request("textDocument/diagnostic", {"textDocument": {"uri": uri}})["items"]
        assert [each["code"] for each in items] == ["unknown-name"]
        client.notify("$/cancelRequest", {"id": asked})
        assert client.answer(asked)["error"]["code"] == -32800


def test_unreadable_files_have_no_diagnostics(tmp_path: Path) -> None:
    (tmp_path / "a.improv").write_bytes(b"\xff")
    (tmp_path / "b.improv").symlink_to(tmp_path / "nothing")
    with Client({"onSave": "off"}, capabilities=PULLS, folders=[tmp_path]) as client:
        assert set(map(str, codes(pull(client)).values())) <= {"[]"}
