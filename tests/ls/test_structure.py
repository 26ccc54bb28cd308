"""Outline, folding, selection and the names of a workspace, in an editor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from improv_ls import programs
from improv_ls.programs import programs_in
from tests.ls.client import CAPABILITIES, Client

URI = "untitled:Untitled-1"
PROGRAM = "beat 30\r\n𝑥 = (left\r\n  up # 🐢\r\n)\r\nr s $ 𝑥\r\n"
DOCUMENT = {"textDocument": {"uri": URI}}


def spot(place: dict[str, Any]) -> tuple[int, int, int, int]:
    start, end = place["start"], place["end"]
    return start["line"], start["character"], end["line"], end["character"]


def test_outline_in_two_forms() -> None:
    nested = {**CAPABILITIES, "textDocument": {"documentSymbol": {"hierarchicalDocumentSymbolSupport": True}}}
    with Client(capabilities=nested) as client:
        client.open(URI, PROGRAM)
        beat, name, robots = client.request("textDocument/documentSymbol", DOCUMENT)
        assert (beat["name"], name["name"], name["detail"]) == ("beat 30", "𝑥", "2 beats")
        assert (spot(name["range"]), spot(name["selectionRange"])) == ((1, 0, 3, 1), (1, 0, 1, 2))
        assert (robots["name"], [part["name"] for part in robots["children"]]) == ("r s", ["r", "s"])
    with Client() as client:
        client.open(URI, PROGRAM)
        found = client.request("textDocument/documentSymbol", DOCUMENT)
        assert [(each["name"], each["location"]["uri"]) for each in found] == [
            (name, URI) for name in ("beat 30", "𝑥", "r", "s")
        ]


def test_folding_and_selection() -> None:
    with Client() as client:
        client.open(URI, PROGRAM)
        assert client.request("textDocument/foldingRange", DOCUMENT) == [{"startLine": 1, "endLine": 2}]
        positions = [{"line": 1, "character": 7}, {"line": 9, "character": 0}]
        first, second = client.request("textDocument/selectionRange", {**DOCUMENT, "positions": positions})
        steps = []
        while first:
            steps.append(spot(first["range"]))
            first = first.get("parent")
        assert steps == [(1, 6, 1, 10), (1, 6, 2, 4), (1, 5, 3, 1), (1, 0, 3, 1), (0, 0, 5, 0)]
        assert spot(second["range"]) == (0, 0, 5, 0)


def test_names_in_open_programs_and_in_files_of_all_folders(tmp_path: Path) -> None:
    one, other = tmp_path / "one", tmp_path / "an other"
    for folder in (one, one / "deep", one / ".hidden", other):
        folder.mkdir()
        (folder / "dance.improv").write_text(f"wave_{folder.name[0]} = up\r\nanna $ up\n", newline="")
    (one / "broken.improv").write_bytes(b"wave\xff = up\n")
    with Client(folders=[one, other]) as client:
        client.open((one / "dance.improv").as_uri(), "# 🐢\nnew_wave = up\n")
        client.open(URI, "unsaved_wave = up\n")
        found = client.request("workspace/symbol", {"query": "WAV"})
        assert [each["name"] for each in found] == ["new_wave", "unsaved_wave", "wave_a", "wave_d"]
        assert found[2]["location"]["uri"] == (other / "dance.improv").as_uri()
        assert spot(found[0]["location"]["range"]) == (1, 0, 1, 8)
        (other / "dance.improv").write_text("later_wave = left up\n")
        found = client.request("workspace/symbol", {"query": ""})
        assert [each["name"] for each in found] == ["new_wave", "unsaved_wave", "later_wave", "wave_d", "anna"]


def test_a_huge_folder_is_searched_only_in_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(5):
        (tmp_path / f"{number}.improv").touch()
    assert programs_in([tmp_path]).complete
    monkeypatch.setattr(programs, "MAX_FILES", 3)
    found = programs_in([tmp_path])
    assert (len(found.paths), found.complete) == (3, False)
