"""Files that are renamed or deleted, folders that are added, canceled requests, settings, and the end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from improv_ls.handlers.workspace_symbol import search
from tests.ls.client import QUIET, TOLD, Client, place, span
from tests.stage_on_thread import running

SILENT = {"onSave": "off"}
FILES = {"workspace": {"fileOperations": {"didRename": True, "didDelete": True}}}
PROGRAM = "# 🐢\r\nwave = up\r\nanna $ wave\r\n"


def names(client: Client) -> list[tuple[str, str]]:
    """Return all names and robots, and their files."""
    found = client.request("workspace/symbol", {"query": ""})
    return [(each["name"], each["location"]["uri"].rpartition("/")[2]) for each in found]


def renamed(client: Client, old: Path, new: Path) -> None:
    old.rename(new)
    params = {"files": [{"oldUri": old.as_uri(), "newUri": new.as_uri()}]}
    client.notify("workspace/didRenameFiles", params)


def test_a_document_is_removed_with_its_file(tmp_path: Path) -> None:
    """The editor neither closes nor opens it."""
    old, new, robots = tmp_path / "old.improv", tmp_path / "new" / "ne w.improv", tmp_path / "improv.toml"
    old.write_text(PROGRAM)
    new.parent.mkdir()
    (new.parent / "improv.toml").write_text("[robots.berta]\n")
    robots.write_text("[robots.anna]\nprofil = 1\n")
    with Client(SILENT, capabilities=FILES) as client:
        offered = client.initialized["capabilities"]["workspace"]["fileOperations"]
        assert set(offered) == {"didRename", "didDelete"}
        client.open(old.as_uri(), PROGRAM)
        assert client.codes_of(robots) == ["robots"]
        renamed(client, old, new)
        assert client.codes_of(old) == []
        assert client.codes_of(robots) == []
        assert client.codes_of(new) == ["unknown-robot"]
        end = span(2, 7, 11)
        client.change(new.as_uri(), 2, {"range": end, "text": "wav"})
        assert client.codes_of(new) == ["unknown-robot", "unknown-name"]
        assert names(client) == [("wave", "ne%20w.improv"), ("anna", "ne%20w.improv")]


def test_documents_are_removed_with_their_folder_and_others_stay(tmp_path: Path) -> None:
    paths = [tmp_path / "one" / "a.improv", tmp_path / "one" / "deep" / "b.improv", tmp_path / "one_more" / "c.improv"]
    with Client(SILENT, capabilities=FILES) as client:
        for path in paths:
            path.parent.mkdir(exist_ok=True)
            client.open(path.as_uri(), PROGRAM)
        renamed(client, tmp_path / "one", tmp_path / "two")
        uris = [each["location"]["uri"] for each in client.request("workspace/symbol", {"query": "wave"})]
        two = [tmp_path / "two" / "a.improv", tmp_path / "two" / "deep" / "b.improv"]
        assert sorted(uris) == sorted(path.as_uri() for path in [*two, paths[2]])


def test_an_editor_that_closes_and_opens_it_is_not_disturbed(tmp_path: Path) -> None:
    old, new = tmp_path / "old.improv", tmp_path / "new.improv"
    old.touch()
    with Client(SILENT, capabilities=FILES) as client:
        client.open(old.as_uri(), PROGRAM)
        client.notify("textDocument/didClose", {"textDocument": {"uri": old.as_uri()}})
        client.open(new.as_uri(), "berta $ up\n")
        renamed(client, old, new)
        assert names(client) == [("berta", "new.improv")]


def test_a_playing_program_stops_when_its_file_is_deleted(tmp_path: Path) -> None:
    old, new = tmp_path / "old.improv", tmp_path / "new.improv"
    old.touch()
    with Client(QUIET, capabilities={**TOLD, **FILES}) as client:
        client.open(old.as_uri(), "anna $ repeat up\n")
        client.save(old.as_uri())
        assert client.wait("improv/lit")["uri"] == old.as_uri()
        renamed(client, old, new)
        client.wait("improv/transport", lambda params: params["uri"] == new.as_uri())


def test_robots_are_removed_with_their_file_and_an_open_program_stays(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    robots.write_text("[robots.berta]\n")
    with Client(SILENT, capabilities=FILES) as client:
        client.open(program.as_uri(), PROGRAM)
        assert client.codes_of(program) == ["unknown-robot"]
        robots.unlink()
        gone = [{"uri": robots.as_uri()}, {"uri": program.as_uri()}]
        client.notify("workspace/didDeleteFiles", {"files": gone})
        assert client.codes_of(program) == []
        assert names(client) == [("wave", "dance.improv"), ("anna", "dance.improv")]


def test_folders_come_and_go(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "other"
    for folder in (one, other):
        folder.mkdir()
        (folder / f"{folder.name}.improv").write_text(f"{folder.name} = up\n")
    with Client(SILENT, folders=[one]) as client:
        assert names(client) == [("one", "one.improv")]
        added, removed = ({"uri": folder.as_uri(), "name": folder.name} for folder in (other, one))
        event = {"event": {"added": [added], "removed": [removed]}}
        client.notify("workspace/didChangeWorkspaceFolders", event)
        assert names(client) == [("other", "other.improv")]


def test_closed_documents_are_forgotten_and_unopened_ones_are_unknown() -> None:
    uri, document = "file:///nowhere/dance.improv", {"textDocument": {"uri": "file:///nowhere/dance.improv"}}
    with Client(SILENT) as client:
        client.open(uri, PROGRAM)
        client.notify("textDocument/didClose", document)
        client.notify("textDocument/didClose", document)
        client.change(uri, 2, {"text": "r $ up\n"})
        for method in ("codeLens", "foldingRange", "documentSymbol"):
            assert client.request(f"textDocument/{method}", document) == []
        assert client.request("textDocument/hover", place(uri, 1, 0)) is None


def test_a_request_canceled_before_it_starts_never_starts() -> None:
    with Client(SILENT) as client:
        client.open("file:///dance.improv", PROGRAM)
        document = {"textDocument": {"uri": "file:///dance.improv"}}
        number = client.begin("textDocument/foldingRange", document, cancelled=True)
        assert client.answer(number)["error"]["code"] == CANCELLED
        assert client.request("textDocument/documentSymbol", document)


def test_a_slow_request_that_is_canceled_is_answered_at_once(tmp_path: Path) -> None:
    for number in range(100):
        (tmp_path / f"{number}.improv").write_text("wave = forward left\n" * 9_000)
    with Client(SILENT, folders=[tmp_path]) as client:
        search = client.begin("workspace/symbol", {"query": "none has all of these letters"})
        assert client.request("textDocument/codeLens", {"textDocument": {"uri": "file:///x.improv"}}) == []
        client.notify("$/cancelRequest", {"id": search})
        assert client.answer(search)["error"]["code"] == CANCELLED


def test_a_canceled_search_ends(tmp_path: Path) -> None:
    (tmp_path / "a.improv").write_text(PROGRAM)
    assert len(search([], [tmp_path], "", "utf-16")) == 2
    assert search([], [tmp_path], "", "utf-16", lambda: True) == []


def test_the_answer_to_shutdown_waits_until_the_stages_have_ended() -> None:
    others = running()
    with Client(QUIET) as client:
        client.play("file:///dance.improv", "anna $ repeat up\n")
        assert running() - others
        client.request("shutdown", None)
        assert not running() - others
        client.notify("exit", None)
        client.wait_for_end()


@pytest.mark.parametrize("pulled", [False, True])
def test_a_bad_setting_is_reported_once_however_often_it_is_sent(pulled: bool) -> None:
    def given(**settings: Any) -> None:
        sent = None if pulled else {"improv": settings}
        client.configuration = settings
        client.notify("workspace/didChangeConfiguration", {"settings": sent})
        if pulled:
            client.wait("workspace/configuration")

    with Client(SILENT) as client:
        client.wait("workspace/configuration")
        given(onSave="somtimes")
        told = client.wait_for_line("improv.onSave: expected restart, continue or off, got 'somtimes'")
        given(onSave="somtimes", codeLens=True)
        given(onSave="somtimes", codeLens=3)
        client.wait_for_line("improv.codeLens: expected true or false, got 3")
        given(onSave="off", codeLens=True)
        given(onSave="somtimes")
        assert client.wait_for_line("improv.onSave") == told
        assert not any(each["method"] == "window/showMessage" for each in client.notifications)


CANCELLED = -32800
