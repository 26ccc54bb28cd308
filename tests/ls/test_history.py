"""The history, as an editor's session writes it."""

from __future__ import annotations

from pathlib import Path

from tests.ls.client import QUIET, Client

URI = "file:///dances/dance.improv"


def save(client: Client, version: int, text: str) -> str:
    """Save a text and return the line about the dance."""
    client.change(URI, version, {"text": text})
    client.save(URI)
    return client.wait_for_line("▶")


def said(client: Client, part: str) -> int:
    """Count the messages with this part that the person has seen."""
    shown = (each.message["params"] for each in client.log if each.message.get("method") == "window/showMessage")
    return sum(part in each["message"] for each in shown)


def test_the_previous_version_plays_and_then_the_one_before_it(state: Path) -> None:
    with Client({**QUIET, "onSave": "restart"}) as client:
        client.open(URI, "")
        played = [save(client, robots, f"{' '.join('abcd'[:robots])} $ forward\n") for robots in (2, 3, 4)]
        assert len(set(played)) == 3

        def before() -> str:
            client.command("before")
            return client.wait_for_line("")

        assert before() == played[1]
        client.command("restart")
        assert client.wait_for_line("▶") == played[1]
        assert before() == played[0]
        assert before() == "improv.before: no earlier version of dance.improv has been kept"
        assert save(client, 5, "a b c d $ forward\n") == played[2]
        assert before() == played[0]
        listed = client.command("history")
        assert [each["line"] for each in listed] == [
            f"{robots} $ forward" for robots in ("a b", "a b c d", "a b", "a b c", "a b c d", "a b c", "a b")
        ]
        assert {each["name"] for each in listed} == {"dances/dance.improv"}
        assert client.command("history", listed[1]["id"]) == "a b c d $ forward\n"
        assert client.command("history", "../../secret") is None
        assert "expected no argument" in client.wait_for_line("improv.history")


def test_each_program_has_its_own_history(state: Path) -> None:
    other = "file:///dances/other.improv"
    with Client({**QUIET, "onSave": "restart"}) as client:
        for uri in (URI, other):
            client.open(uri, "")
            for beats in (2, 3, 4):
                client.change(uri, beats, {"text": f"r $ repeat {beats} forward\n"})
                client.save(uri)
                client.wait_for_line(f"▶ r {beats} beats")

        def before(uri: str) -> str:
            client.command("before", uri)
            return client.wait_for_line("").partition(",")[0]

        assert [before(URI), before(URI)] == ["▶ r 4 beats", "▶ r 3 beats"]
        assert before(other) == "▶ r 4 beats"
        assert before(URI) == "▶ r 3 beats"


def test_an_unusable_history_is_reported_once_and_the_program_plays(state: Path) -> None:
    state.parent.mkdir(parents=True)
    state.write_text("no folder")
    with Client({**QUIET, "onSave": "restart"}) as client:
        client.open(URI, "")
        for version in (2, 3):
            assert save(client, version, f"r $ forward {version * 'left '}\n")
        assert client.command("history") == []
        assert said(client, "was not kept in the history") >= 1
        state.unlink()
        save(client, 4, "r $ left\n")
        assert len(client.command("history")) == 1  # which waits until it has been written
        (state / "5.improv").write_bytes(b"\xff")
        assert len(client.command("history")) == 1
        client.wait_for_line("1 file of the history can't be read")
    assert said(client, "was not kept in the history") == 1
