"""improv.toml as an editor sees it: its mistakes are its own, and what it says is held against the program."""

from __future__ import annotations

from pathlib import Path

from tests.ls.client import Client

QUIET = {"backend": "sim", "page": {"open": False}}
BURGER = '[robots.burger]\nprofile = "turtlebot3_burger"\n'


def codes(client: Client, path: Path) -> list[str]:
    published = client.wait("textDocument/publishDiagnostics", lambda params: params["uri"] == path.as_uri())
    return [each["code"] for each in published["diagnostics"]]


def test_robots_and_limits_are_those_of_the_file(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    robots.write_text(BURGER)
    with Client(QUIET) as client:
        client.open(program.as_uri(), "beat 120\nburger $ forward strafeleft\nbruger $ rest\n")
        assert codes(client, program) == ["too-fast", "unsupported-direction", "unknown-robot"]
        assert codes(client, robots) == []

        # A mistake in the file is told in the file, and stops every new dance until it is mended.
        robots.write_text(BURGER.replace("burger", "brger"))
        client.save(program.as_uri())
        assert client.wait_for_line("✗") == "✗ improv.toml has errors"
        robots.write_text(BURGER + '[robots.bruger]\nprofile = "holonomic"\n')
        client.change(program.as_uri(), 2, {"text": "beat 30\nburger $ forward left\nbruger $ strafeleft\n"})
        client.save(program.as_uri())
        assert client.wait_for_line("▶") == "▶ burger 2 beats · bruger 1 beat, 4.0 s at beat 30, simulator"


def test_the_file_is_read_again_when_it_changes(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    watched = {"workspace": {"didChangeWatchedFiles": {"dynamicRegistration": True}}}
    with Client(QUIET, capabilities=watched) as client:
        client.open(program.as_uri(), "bruger $ forward\n")
        assert codes(client, program) == []
        client.wait("client/registerCapability")
        robots.write_text(BURGER)
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 1}]})
        assert codes(client, program) == ["unknown-robot"]
        robots.unlink()
        client.notify("workspace/didChangeWatchedFiles", {"changes": [{"uri": robots.as_uri(), "type": 3}]})
        assert codes(client, program) == []


def test_robots_of_a_file_that_can_not_be_read_do_not_move(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    robots.write_bytes(b"# \xff\n")
    with Client(QUIET) as client:
        client.open(program.as_uri(), "r $ forward\n")
        assert codes(client, robots) == ["robots"]
        client.save(program.as_uri())
        assert client.wait_for_line("✗") == "✗ improv.toml has errors"
        robots.write_text("")
        client.save(program.as_uri())
        assert client.wait_for_line("▶").startswith("▶ r 1 beat")
