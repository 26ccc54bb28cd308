"""improv.toml in an editor: it shows the file's errors, and programs are checked against it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from shutil import rmtree

import pytest
from lsprotocol import types

from improv_core.text import LineIndex
from improv_ls.documents import RobotsFile, changed_file
from improv_ls.urdfs import SMALL
from tests.ls.client import QUIET, Client
from tests.robots.test_skeletons import TOML, URDF

BURGER = '[robots.burger]\nprofile = "turtlebot3_burger"\n'


def test_the_file_is_read_again_when_it_changes(tmp_path: Path) -> None:
    folder = tmp_path / "dances"
    folder.mkdir()
    program, robots = folder / "dance.improv", folder / "improv.toml"
    watched = {"workspace": {"didChangeWatchedFiles": {"dynamicRegistration": True}}}
    with Client(QUIET, capabilities=watched) as client:
        client.open(program.as_uri(), "bruger $ forward\n")
        assert client.codes_of(program) == []
        client.wait("client/registerCapability")
        robots.write_text(BURGER)
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 1}]})
        assert client.codes_of(program) == ["unknown-robot"]
        robots.unlink()
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 3}]})
        assert client.codes_of(program) == []
        robots.write_text(BURGER)
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 1}]})
        assert client.codes_of(program) == ["unknown-robot"]
        rmtree(folder)
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": folder.as_uri(), "type": 3}]})
        assert client.codes_of(program) == []


def test_a_urdf_is_read_again_when_it_changes(tmp_path: Path) -> None:
    """It doesn't matter if the file that names it is open."""
    program, robots, urdf = tmp_path / "dance.improv", tmp_path / "improv.toml", tmp_path / "r.urdf"
    robots.write_text(TOML)
    changes = [{"uri": urdf.as_uri(), "type": 2}]
    with Client(QUIET) as client:
        client.open(program.as_uri(), "ada $ head left\n")
        assert client.codes_of(robots) == ["robots"]
        for text, found in ((URDF, []), ("<robot/>", ["robots"]), (URDF, [])):
            urdf.write_text(text)
            client.notify("workspace/didChangeWatchedFiles", {"changes": changes})
            assert client.codes_of(robots) == found
        client.open(robots.as_uri(), TOML, "toml")
        assert client.codes_of(robots) == []
        urdf.write_text("<robot/>")
        client.notify("workspace/didChangeWatchedFiles", {"changes": changes})
        assert client.codes_of(robots) == ["robots"]


def test_a_program_waits_for_a_large_urdf_and_then_plays(tmp_path: Path) -> None:
    program, robots, urdf = tmp_path / "dance.improv", tmp_path / "improv.toml", tmp_path / "r.urdf"
    robots.write_text(TOML)
    padding = "<gazebo/>" * (4 * SMALL // 9)
    urdf.write_text(URDF.replace("</robot>", f"{padding}</robot>"))
    with Client(QUIET, hurries=True) as client:
        assert client.play(program.as_uri(), "ada $ head left\n").startswith("▶ ada 1 beat")
        assert client.codes_of(program) == []
        while client.codes_of(robots):
            pass
        urdf.write_text(URDF.replace("</robot>", f"{padding}<link/></robot>"))
        client.save(program.as_uri())
        assert client.wait_for_line("✗").startswith("✗ improv.toml has errors")


@pytest.mark.parametrize(
    ("make", "problem"),
    [(lambda robots: robots.write_bytes(b"# \xff\n"), "it is not UTF-8 text"), (os.mkfifo, "it is not a regular file")],
)
def test_robots_in_an_unreadable_file_do_not_move(tmp_path: Path, make: Callable[[Path], object], problem: str) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    with Client(QUIET) as client:
        client.play(program.as_uri(), "r $ repeat forward\n")
        make(robots)
        client.save(program.as_uri())
        assert client.wait_for_line("✗") == f"✗ {robots}: {problem}; the previous dance keeps playing"
        assert client.codes_of(robots) == ["robots"]
        robots.unlink()
        client.save(program.as_uri())
        assert client.wait_for_line("▶").startswith("▶ r ∞")


def test_after_improv_toml_is_deleted_only_the_second_save_plays(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    robots.write_text("[robots.r]\n")
    with Client(QUIET) as client:
        client.play(program.as_uri(), "r $ repeat forward\n")
        robots.unlink()
        client.save(program.as_uri())
        gone = f"✗ {robots} is gone: save again to play without its limits; the previous dance keeps playing"
        assert client.wait_for_line("✗") == gone
        client.save(program.as_uri())
        assert client.wait_for_line("▶").startswith("▶ r ∞")


def test_each_change_of_an_open_file_applies_to_the_result_of_the_one_before() -> None:
    def change(line: int, start: int, end: int, text: str) -> types.TextDocumentContentChangePartial:
        span = types.Range(types.Position(line, start), types.Position(line, end))
        return types.TextDocumentContentChangePartial(span, text)

    file = RobotsFile("file:///improv.toml", 1, LineIndex("# \U0001f422 [robots.ada]\n"))
    changes = [change(0, 0, 5, ""), change(1, 0, 0, 'profile = ""\n'), change(1, 11, 11, "turtlesim")]
    after = changed_file(file, 2, changes, types.PositionEncodingKind.Utf16)  # a turtle is two units
    assert (after.version, after.lines.text) == (2, '[robots.ada]\nprofile = "turtlesim"\n')


@pytest.mark.parametrize("language", ["toml", "improv", ""])
def test_an_open_improv_toml_is_not_a_program(tmp_path: Path, language: str) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    robots.write_text(BURGER)
    with Client(QUIET) as client:
        client.open(robots.as_uri(), BURGER, language)
        client.change(robots.as_uri(), 2, {"text": "r $ forward\n"})
        assert client.request("textDocument/documentSymbol", {"textDocument": {"uri": robots.as_uri()}}) == []
        client.open(program.as_uri(), "burger $ forward\n")
        assert (client.codes_of(program), client.codes_of(robots)) == ([], [])
        assert [each["name"] for each in client.request("workspace/symbol", {"query": ""})] == ["burger"]
        # With one program open, it is clear which one to play.
        client.command("play")
        assert client.wait_for_line("▶").startswith("▶ burger 1 beat")


def test_only_programs_are_served(tmp_path: Path) -> None:
    with Client(QUIET) as client:
        for name, language, is_program in [
            ("dance.improv", "improv", True),
            ("other.improv", "plaintext", True),
            ("dance", "improv", True),
            ("notes.md", "markdown", False),
            ("other.toml", "toml", False),
        ]:
            uri = (tmp_path / name).as_uri()
            client.open(uri, "r $ forward\n", language)
            assert bool(client.request("textDocument/documentSymbol", {"textDocument": {"uri": uri}})) == is_program
