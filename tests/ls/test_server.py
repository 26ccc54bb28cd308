"""The server as an editor uses it, over standard input and output."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from improv_core.ipc.stage_process import Stage, StageError
from improv_ls import editor
from improv_ls.server import COMMANDS
from tests.ls.client import LIMIT, QUIET, TOLD, TURNS, Client, Message, ProcessClient, place, places, span
from tests.open_page import connected, live_behind
from tests.processes import descendants, wait_until_gone
from tests.stage_on_thread import StageOnThread

REFRESHED = {"workspace": {"configuration": True, "inlayHint": {"refreshSupport": True}}}
URI = "file:///dance.improv"


@pytest.fixture
def client() -> Iterator[Client]:
    with Client(QUIET) as client:
        yield client


def diagnostics(client: Client, version: int) -> list[tuple[int, int, int, str]]:
    """Return line, first and last column, and code of each diagnostic of a version."""
    params = client.wait("textDocument/publishDiagnostics", lambda params: params["version"] == version)
    return places(params["diagnostics"])


def test_diagnostics_follow_the_text_in_utf_16(client: Client) -> None:
    client.open(URI, "# 😀\nr $ foward # 😀\n")
    assert diagnostics(client, 1) == [(1, 4, 10, "unknown-name")]
    client.change(URI, 2, {"range": span(1, 4, 10), "text": "left"})
    assert diagnostics(client, 2) == []
    client.change(URI, 3, {"range": span(0, 4, 0, last=1), "text": "\r\n"}, {"range": span(1, 0, 0), "text": "x "})
    assert diagnostics(client, 3) == []
    client.change(URI, 4, {"text": "r $ (left 😀"})
    assert diagnostics(client, 4) == [(0, 4, 5, "unclosed-bracket")]
    client.notify("textDocument/didClose", {"textDocument": {"uri": URI}})
    assert client.wait("textDocument/publishDiagnostics")["diagnostics"] == []


@pytest.mark.parametrize(("snippets", "written"), [(True, "1.5"), (False, "")])
def test_units_pass_the_filters_of_editors_that_compare_them_with_the_whole_number(
    snippets: bool, written: str
) -> None:
    """Editors with snippets replace a number, and filter by it."""
    item = {"completionItem": {"snippetSupport": snippets}}
    with Client(QUIET, {"textDocument": {"completion": item}}) as client:
        client.open(URI, "r $ forward 1.5 left 90d\n")
        offered = client.request("textDocument/completion", place(URI, 0, 15))["items"][0]
        assert (offered["label"], offered["filterText"]) == ("1.5m", "1.5m")
        assert offered["textEdit"] == {"range": span(0, 15 - len(written), 15), "newText": f"{written}m"}
        offered = client.request("textDocument/completion", place(URI, 0, 24))["items"][0]
        assert offered["filterText"] == ("90deg" if snippets else "deg")
        assert offered["textEdit"]["range"] == span(0, 21 if snippets else 23, 24)


def test_save_plays_and_says_so_in_one_line(client: Client) -> None:
    said = client.play(URI, "beat 6\nr1 $ forward left\nr2 $ left\n")
    assert said == "▶ r1 2 beats · r2 1 beat, 20.0 s at beat 6, simulator"
    begin = client.wait("$/progress", lambda params: params["value"]["kind"] == "begin")
    assert begin["value"]["message"] in ("beat 1/2", "beat 2/2")
    client.command("seek", 1.95)
    client.wait("$/progress", lambda params: params["value"]["kind"] == "end")


def test_a_save_with_errors_says_why_and_the_dance_keeps_playing(
    monkeypatch: pytest.MonkeyPatch, client: Client
) -> None:
    client.open(URI, "r $ repeat left\n")
    client.save(URI)
    client.wait_for_line("▶ r ∞, endless at beat 60, simulator")
    monkeypatch.setattr(editor, "READING", 1.0)
    client.change(URI, 2, {"text": "r $ repeat lft )\n"})
    client.save(URI)
    line = client.wait_for_line("✗")
    assert line == "✗ line 1: `lft` is not defined: did you mean `left`? (and 1 more); the previous dance keeps playing"
    client.wait("$/progress", lambda params: beat(params) >= 1 + editor.READING)  # until then, people can read the line


def beat(progress: Message) -> int:
    """Return the beat of a report, counted from 1; 0 if it has none."""
    message = progress["value"].get("message", "")
    return int(message.removeprefix("beat ").split("/")[0]) if message else 0


def test_a_playing_program_can_be_controlled(client: Client) -> None:
    def shows(kind: str, least: int = 0) -> None:
        client.wait("$/progress", lambda params: params["value"]["kind"] == kind and beat(params) >= least)

    client.open(URI, "r $ repeat left\n")
    client.save(URI)
    shows("begin")
    client.command("pause")
    shows("end")
    client.command("seek", 41.5)
    client.command("resume")
    shows("begin", 42)
    client.command("speed", 4)
    shows("end")
    shows("report", 44)
    client.command("mute", "r")
    client.command("solo", "r")
    client.command("stop")
    shows("end")


def test_a_command_with_wrong_arguments_lists_its_arguments(client: Client) -> None:
    assert client.initialized["capabilities"]["executeCommandProvider"]["commands"] == [*COMMANDS]
    wrong: list[tuple[str, list[object], str]] = [
        ("seek", ["three"], "improv.seek: expected a beat, counted from 0"),
        ("seek", [-1], "improv.seek: expected a beat, counted from 0"),
        ("seek", [10**400], "improv.seek: expected a beat, counted from 0"),
        ("speed", [5], "improv.speed: expected a number from 0.1 to 4"),
        ("speed", [], "improv.speed: expected a number from 0.1 to 4"),
        ("mute", [], "improv.mute: expected a robot's name"),
        ("solo", [7], "improv.solo: expected a robot's name"),
        ("solo", ["nobody"], "improv.solo: no robot is named `nobody`"),
    ]
    for name, arguments, line in wrong:
        client.command(name, *arguments)
        assert client.wait_for_line("improv.") == line


def test_an_editor_learns_if_its_window_shows_the_page() -> None:
    with Client({"backend": "sim"}, capabilities={**TOLD, "window": {"showDocument": {"support": True}}}) as client:
        client.open(URI, "")
        client.change(URI, 2, {"text": "r $ repeat forward\n"})
        client.save(URI)
        live = live_behind(client.wait_for_page()[0])

        async def show() -> None:
            async with connected(f"{live}&framed=true"):
                await asyncio.to_thread(client.wait, "improv/transport", lambda told: told["framed"] == 1)
            await asyncio.to_thread(client.wait, "improv/transport", lambda told: told["framed"] == 0)

        asyncio.run(show())


def test_an_editor_that_asks_gets_the_lit_words() -> None:
    with Client(QUIET, capabilities=TOLD) as client:
        client.open(URI, "")
        client.change(URI, 2, {"text": "beat 6 # 🐢\r\nr $ forward  left\r\ns $ repeat left\r\n"})
        client.save(URI)
        assert client.wait("improv/lit") == {"uri": URI, "version": 2, "ranges": [[1, 4, 1, 11], [2, 11, 2, 15]]}
        first = client.wait("improv/transport", lambda params: params["state"] == "playing")
        assert (first["generation"], first["tempo"], first["beats"], first["uri"]) == (1, 6, None, URI)
        assert (first["counted"], first["robots"], first["real"]) == ("beat 1/∞", ["r", "s"], False)
        client.command("seek", 1)
        assert client.wait("improv/lit")["ranges"] == [[1, 13, 1, 17], [2, 11, 2, 15]]
        later = client.wait("improv/transport")
        assert (later["counted"], 1 <= later["beat"] < 2) == ("beat 2/∞", True)
        client.change(URI, 3, {"text": "# now\n\nbeat 6 # 🐢\r\nr $ forward  left\r\ns $ repeat left\r\n"})
        client.command("seek", 2)
        assert client.wait("improv/lit") == {"uri": URI, "version": 3, "ranges": [[4, 11, 4, 15]]}
        client.command("mute", "s")
        assert client.wait("improv/lit")["ranges"] == []
        client.command("mute", "s")
        assert client.wait("improv/lit")["ranges"] == [[4, 11, 4, 15]]
        client.command("stop")
        assert client.wait("improv/lit")["ranges"] == []
        client.wait("improv/transport", lambda params: params["state"] == "stopped")


def test_the_server_ends_with_the_editor_even_if_its_input_stays_open() -> None:
    editor = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    with ProcessClient(QUIET, process=editor.pid) as client:
        client.play(URI, "r $ repeat left\n")
        children = descendants(client.process.pid)
        editor.kill()
        editor.wait()
        client.code = 1
        client.process.wait(LIMIT)
        wait_until_gone(children, LIMIT)


def test_the_saved_text_plays_and_not_later_edits() -> None:
    """An editor whose server starts after the save sends the saved text along with it."""
    with Client(QUIET, {"experimental": {"improv": True}}) as client:
        client.open(URI, "# 🐢\r\nr $ repeat left\r\ns $ repeat (lef\r\n")
        client.save(URI, "r $ repeat left\r\n")
        assert diagnostics(client, 1)[0][0] == 2
        assert client.wait_for_line("▶").startswith("▶ r ∞, endless")
        lit = client.wait("improv/lit")
        assert (lit["version"], lit["ranges"]) == (1, [[1, 11, 1, 15]])  # its place by now
        client.save(URI, "r $ repeat (\r\n")
        client.wait_for_line("✗ line 1")


def test_a_save_and_a_command_may_spell_the_uri_in_another_way() -> None:
    spelled = "file:///m%C3%BCde.improv", "file:///müde.improv"
    for opened, other in (spelled, spelled[::-1]):
        with Client(QUIET) as client:
            client.open(opened, "r $ repeat left\n")
            client.save(other)
            client.wait_for_line("▶ r ∞")
            client.command("play", other)
            client.wait_for_line("▶ r ∞")


def test_progress_that_was_created_ends() -> None:
    shows = {"window": {"workDoneProgress": True}, "experimental": {"improv": True}}
    with Client({"backend": "sim"}, shows) as client:
        client.play(URI, "beat 600\nr $ left\n")
        client.wait_for_line("page: ")  # Helix would overwrite that with the beat
        client.wait("improv/transport", lambda told: told["state"] == "ended")
        client.request("workspace/symbol", {"query": ""})
    assert ended(client) >= {each["params"]["token"] for each in sent(client, "window/workDoneProgress/create")}
    with Client(QUIET, answers=False) as silent:
        silent.play(URI, "r $ repeat left\n")
        silent.wait("window/workDoneProgress/create")
        silent.command("stop")
        silent.wait("$/progress", lambda params: params["value"]["kind"] == "end")


def sent(client: Client, method: str) -> list[Message]:
    return [each.message for each in client.log if each.message.get("method") == method]


def ended(client: Client) -> set[str]:
    """Return the tokens of progress that has ended."""
    return {each["params"]["token"] for each in sent(client, "$/progress") if each["params"]["value"]["kind"] == "end"}


def will_save(client: Client, reason: int) -> None:
    client.notify("textDocument/willSave", {"textDocument": {"uri": URI}, "reason": reason})


def test_an_autosave_moves_nothing_and_one_that_failed_does_not_keep_the_next_save_from_playing(client: Client) -> None:
    client.open(URI, "r $ repeat left\n")
    for reason in (2, 3):  # after a delay, when the focus left
        will_save(client, reason)
        client.save(URI)
    client.change(URI, 2, {"text": "s $ repeat left\n"})
    will_save(client, 2)
    will_save(client, 1)
    client.save(URI)
    assert client.wait_for_line("▶").startswith("▶ s ∞")


def test_a_save_that_ends_after_a_stop_plays_nothing_if_it_began_before_that(client: Client) -> None:
    client.open(URI, "r $ repeat left\n")
    will_save(client, 1)
    client.command("stop")
    client.save(URI)
    assert client.wait_for_line("r").startswith("■ dance.improv was stopped before it began")
    will_save(client, 1)
    client.save(URI)
    client.wait_for_line("▶ r ∞")


def test_page_is_shown_once() -> None:
    with Client({"backend": "sim"}) as client:
        client.play(URI, "r $ left\n")
        client.save(URI)
        client.wait_for_line("▶")
    assert client.shown == [client.shown[0]]
    assert client.shown[0].startswith("http://127.0.0.1:")


def test_a_silent_client_is_not_waited_for_and_a_late_answer_is_harmless() -> None:
    with Client({**QUIET, "onSave": "restart"}, answers=False) as client:
        client.play(URI, "beat 240\nr $ forward left left left\n")
        client.wait("window/workDoneProgress/create")
        client.save(URI)
        client.wait_for_line("▶")
        client.wait("window/workDoneProgress/create")
        client.answer_late()
        client.command("stop")
        assert not any(message["method"] == "window/showMessage" for message in client.notifications)


def test_settings_count_however_late_the_editor_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """As when VS Code is busy: in a workspace that is trusted by then, a save would play nothing."""
    monkeypatch.setattr("improv_ls.handlers.did_change_configuration.ANSWER_LIMIT", 0, raising=False)
    with Client({**QUIET, "onSave": "off"}, REFRESHED, answers=False) as client:
        client.wait("workspace/configuration")
        client.open(URI, "r $ left\n")
        _hover(client)
        client.configuration = {"onSave": "restart", "inlayHints": {"beats": True}}
        client.answer_late()
        client.wait("workspace/inlayHint/refresh")
        client.save(URI)
        client.wait_for_line("▶")


def test_an_answer_that_a_newer_one_has_overtaken_changes_no_settings() -> None:
    with Client(QUIET, REFRESHED, answers=False) as client:
        client.open(URI, "r $ left\n")
        client.wait("workspace/configuration")
        client.notify("workspace/didChangeConfiguration", {"settings": None})
        client.wait("workspace/configuration")
        client.configuration = {"inlayHints": {"beats": True}}
        client.answer_late(1)
        client.wait("workspace/inlayHint/refresh")
        client.configuration = {"inlayHints": {"beats": False}}
        client.answer_late()
        _hover(client)
        asked = {"textDocument": {"uri": URI}, "range": span(0, 0, 0, last=1)}
        assert client.request("textDocument/inlayHint", asked)


def start_late(monkeypatch: pytest.MonkeyPatch, *failures: StageError) -> threading.Event:
    """Have stages start only once the returned event is set, after these failures."""
    gate, start, failing = threading.Event(), StageOnThread.start, [*failures]

    async def started(*arguments: Any) -> StageOnThread | Stage:
        await asyncio.to_thread(gate.wait, LIMIT)
        if failing:
            raise failing.pop()
        return await start(*arguments)

    monkeypatch.setattr(StageOnThread, "start", started)
    return gate


def test_a_save_plays_even_if_an_earlier_start_of_the_stages_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a machine that is too busy for a moment."""
    gate = start_late(monkeypatch, StageError("the stage did not start in time: try again"))
    with Client(QUIET) as client:
        client.open(URI, "r $ left\n")
        client.save(URI)
        for _ in range(TURNS):  # until it waits for the stages
            _hover(client)
        gate.set()
        client.wait_for_line("▶")


def test_a_save_plays_on_the_stages_that_replace_those_it_waits_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody changes a setting of the stages, and then asks for the page. An older save never plays after a newer
    one."""
    gate = start_late(monkeypatch)
    with Client(QUIET) as client:
        client.open(URI, "r $ left\n")
        client.save(URI)
        client.change(URI, 2, {"text": "r q $ right\n"})
        client.save(URI)
        for _ in range(TURNS):  # until both wait for the stages
            _hover(client)
        client.set(**QUIET, osc={"network": True})
        page = client.begin("workspace/executeCommand", {"command": "improv.page", "arguments": []})
        for _ in range(TURNS):  # until others have replaced these
            _hover(client)
        gate.set()
        client.answer(page)
        client.wait_for_line("▶")
        for _ in range(TURNS):
            _hover(client)
    shown = [each.message["params"] for each in client.log if each.message.get("method") == "window/showMessage"]
    lines = [each["message"] for each in shown if each["message"].startswith(("▶", "■"))]
    assert lines == ["▶ r 1 beat · q 1 beat, 1.0 s at beat 60, simulator"]


def test_settings_come_from_anywhere_and_bad_ones_are_reported_once() -> None:
    with Client({"improv": {**QUIET, "onSave": "sometimes"}}, configuration={"switchAt": 7}) as client:
        assert client.wait_for_line("improv.onSave") == (
            "improv.onSave: expected restart, continue or off, got 'sometimes'; keeping the current value"
        )
        client.wait_for_line("improv.switchAt: expected now, beat, bar or end, got 7")
        client.set(onSave="off")
        client.open(URI, "r $ left\n")
        client.save(URI)
        client.command("play")
        client.wait_for_line("▶")
        assert not any("▶" in str(message) for message in client.notifications)


def _hover(client: Client) -> None:
    """Have the server answer a request, which shows that it waits for nothing else."""
    client.request("textDocument/hover", place(URI, 0, 4))
