"""The history and the study log, as an editor's session writes them."""

from __future__ import annotations

import json
import time
from pathlib import Path

from tests.ls.client import LIMIT, QUIET, TOLD, Client

URI = "file:///dances/dance.improv"


def save(client: Client, version: int, text: str) -> str:
    """Save a text and return what plays."""
    client.change(URI, version, {"text": text})
    client.save(URI)
    return client.wait_for_line("▶")


def said(client: Client, part: str) -> int:
    """How many messages with this part were shown to the person."""
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
        assert {each["name"] for each in listed} == {"dance.improv"}
        assert client.command("history", listed[1]["id"]) == "a b c d $ forward\n"
        assert client.command("history", "../../secret") is None
        assert "expected no argument" in client.wait_for_line("improv.history")


def test_each_program_has_its_own_history_and_playing_one_line_ends_it(state: Path) -> None:
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
        client.command("play", URI, 1)
        assert "r 4 beats" in client.wait_for_line("▶")
        assert before(URI) == "▶ r 3 beats"


def test_an_unusable_history_is_reported_once_and_the_program_plays(state: Path) -> None:
    state.parent.mkdir(parents=True)
    state.write_text("no folder")
    log = state.parent / "none" / "study.jsonl"
    with Client({**QUIET, "onSave": "restart"}) as client:
        for given in ("study.jsonl", "~root.jsonl", "/etc/passwd", 1, str(log)):
            client.notify("workspace/didChangeConfiguration", {"settings": {"improv": {"study": {"log": given}}}})
            if given != str(log):
                line = client.wait_for_line("improv.study.log")
                assert line.endswith(f"a full path that ends in .jsonl, got {given!r}; keeping the current value")
        client.open(URI, "")
        for version in (2, 3):
            assert save(client, version, f"r $ forward {version * 'left '}\n")
        assert client.command("history") == []
        assert said(client, "was not kept in the history") >= 1
        assert said(client, f"{log} can't be written: no such file or directory") >= 1
        state.unlink()
        log.parent.mkdir()
        save(client, 4, "r $ left\n")
        assert len(client.command("history")) == 1
        (state / "5.improv").write_bytes(b"\xff")
        (kept,) = client.command("history")
        assert kept["line"] == "r $ left"
        client.wait_for_line("1 file of the history can't be read")
    assert said(client, "was not kept in the history") == said(client, "can't be written") == 1
    assert log.is_file()


def test_a_study_log_records_what_people_do_and_how_far_robots_move(tmp_path: Path, state: Path) -> None:
    log = tmp_path / "study.jsonl"
    with Client({**QUIET, "study": {"log": str(log)}}, TOLD) as client:
        client.open(URI, "beat 600\nr $ frwd\nq $ 3\n")
        client.save(URI)
        client.wait_for_line("✗")
        save(client, 2, "beat 600\nr $ repeat 4 forward\n")
        client.wait("improv/transport", lambda told: told["state"] == "ended")
        client.command("before")  # there is none, and this is no play
        client.command("play")
        client.wait("improv/transport", lambda told: told["generation"] == 2 and told["state"] == "ended")
    events = [json.loads(line) for line in log.read_text().splitlines()]
    assert len({each.pop("session") for each in events}) == 1
    times = [each.pop("time") for each in events]
    assert times == sorted(times)
    assert time.time() - 10 * LIMIT < times[0] < time.time()
    assert [each for each in events if each["event"] != "moved"] == [
        {"event": "save", "program": "dance.improv", "errors": 2},
        {"event": "error", "program": "dance.improv", "code": "unknown-name", "line": 2},
        {"event": "error", "program": "dance.improv", "code": "syntax", "line": 3},
        {"event": "save", "program": "dance.improv", "errors": 0},
        {"event": "play", "program": "dance.improv", "by": "save", "robots": 1},
        {"event": "play", "program": "dance.improv", "by": "command", "robots": 1},
    ]
    moved = sum(each["meters"]["r"] for each in events if each["event"] == "moved")
    assert moved > 0  # test_study asks how far
    assert (log.stat().st_mode & 0o777) == 0o600
