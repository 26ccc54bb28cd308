"""Diagnostics for editors that ask for them, and the features that each kind of editor supports."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest

from tests.ls.client import Client, places, span

QUIET = {"onSave": "off"}
TOLD = {"relatedInformation": True, "tagSupport": {"valueSet": [1]}}
PULLS = {
    "textDocument": {"diagnostic": {}, "publishDiagnostics": TOLD},
    "workspace": {"diagnostics": {"refreshSupport": True}},
}
URI = "file:///dance.improv"
PROGRAM = "# 🐢\r\n𝑥 = up 𝑦\r\n𝑦 = up\r\n"


def pull(client: Client, uri: str, previous: str | None = None) -> dict[str, Any]:
    before = {"previousResultId": previous} if previous else {}
    answer: dict[str, Any] = client.request("textDocument/diagnostic", {"textDocument": {"uri": uri}, **before})
    return answer


def published(client: Client) -> list[str]:
    """Return the files about which the server has published unasked."""
    return [
        each["params"]["uri"] for each in client.notifications if each["method"] == "textDocument/publishDiagnostics"
    ]


def test_a_client_that_pulls_is_answered_once_and_sent_nothing() -> None:
    with Client(QUIET, capabilities=PULLS) as client:
        assert client.initialized["capabilities"]["diagnosticProvider"] == {
            "identifier": "improv",
            "interFileDependencies": True,
            "workspaceDiagnostics": True,
        }
        client.open(URI, PROGRAM)
        first = pull(client, URI)
        assert (first["kind"], places(first["items"])) == (
            "full",
            [(1, 0, 2, "unused-name"), (1, 8, 10, "used-before-definition")],
        )
        assert first["items"][0]["tags"] == [1]
        (related,) = first["items"][1]["relatedInformation"]
        assert related["location"]["range"]["start"] == {"line": 2, "character": 0}
        assert related["message"] == "`𝑦` is defined here"
        assert pull(client, URI, first["resultId"]) == {"kind": "unchanged", "resultId": first["resultId"]}

        behind = span(3, 0, 0)
        client.change(URI, 2, {"range": behind, "text": "# what is said stays the same\n"})
        assert pull(client, URI, first["resultId"])["kind"] == "unchanged"
        client.change(URI, 3, {"range": {**behind, "start": {"line": 0, "character": 0}}, "text": "\n𝑦 = up\n"})
        second = pull(client, URI, first["resultId"])
        assert (second["kind"], places(second["items"])) == ("full", [(1, 0, 2, "unused-name")])
        assert second["resultId"] != first["resultId"]
        assert pull(client, URI, first["resultId"])["kind"] == "full"

        client.notify("textDocument/didClose", {"textDocument": {"uri": URI}})
        assert pull(client, URI)["items"] == []
        assert published(client) == []


def test_a_client_that_pulls_is_told_to_ask_again_when_the_robots_change(tmp_path: Path) -> None:
    program, robots = (tmp_path / "dance.improv").as_uri(), tmp_path / "improv.toml"
    with Client(QUIET, capabilities=PULLS) as client:
        client.open(program, "anna $ up\n")
        first = pull(client, program)
        assert first["items"] == []
        robots.write_text("[robots.berta]\nspeed = 3\n")
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 1}]})
        client.wait("workspace/diagnostic/refresh")
        assert places(pull(client, program, first["resultId"])["items"]) == [(0, 0, 4, "unknown-robot")]
        # Clients don't ask about improv.toml: that is no document of ours.
        assert published(client) == [robots.as_uri()]
        assert client.codes_of(robots) == ["robots"]
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 2}]})
        client.notify("textDocument/didClose", {"textDocument": {"uri": program}})
        assert client.codes_of(robots) == []
        assert not any(each["method"] == "workspace/diagnostic/refresh" for each in client.notifications)


@pytest.mark.parametrize(
    ("name", "version", "offered"),
    [("Neovim", "0.12.4+v0.12.4", False), ("Neovim", "0.13.0", True), ("Neovim", None, True), ("Zed", "0.12.4", True)],
)
def test_neovim_0_12_is_not_offered_those_of_all_files_as_it_would_refresh_only_these(
    name: str, version: str | None, offered: bool
) -> None:
    about = {"clientInfo": {"name": name, **({"version": version} if version else {})}}
    with Client(QUIET, capabilities=PULLS, about=about) as client:
        provider = client.initialized["capabilities"]["diagnosticProvider"]
        assert provider["workspaceDiagnostics"] is offered
        client.open(URI, PROGRAM)
        assert len(pull(client, URI)["items"]) == 2


@pytest.mark.parametrize(
    "capabilities",
    [
        {},
        {"workspace": {"diagnostics": {"refreshSupport": True}}},
        {"textDocument": {"diagnostic": {}}},  # the server could not ask it to refresh when the robots have changed
    ],
)
def test_other_clients_are_sent_diagnostics_with_their_version(capabilities: dict[str, Any]) -> None:
    with Client(QUIET, capabilities=capabilities) as client:
        assert "diagnosticProvider" not in client.initialized["capabilities"]
        client.open(URI, PROGRAM)
        sent = client.wait("textDocument/publishDiagnostics")
        assert (sent["uri"], sent["version"], len(sent["diagnostics"])) == (URI, 1, 2)
        assert not any({"tags", "relatedInformation", "codeDescription"} & each.keys() for each in sent["diagnostics"])
        client.change(URI, 7, {"text": ""})
        assert client.wait("textDocument/publishDiagnostics") == {"uri": URI, "version": 7, "diagnostics": []}


def test_a_code_links_to_its_section_of_an_existing_page() -> None:
    takes = {"textDocument": {"publishDiagnostics": {"codeDescriptionSupport": True}}}
    with Client(QUIET, capabilities=takes) as client:
        client.open(URI, PROGRAM)
        for found in client.wait("textDocument/publishDiagnostics")["diagnostics"]:
            page, _, line = found["codeDescription"]["href"].partition("#L")
            path = Path(unquote(urlsplit(page).path))
            assert path.read_text("utf-8").splitlines()[int(line) - 1] == f"## {found['code']}"
