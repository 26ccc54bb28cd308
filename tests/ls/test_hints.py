"""Texts that an editor shows between words and lines, and the indentation of typed lines; columns in UTF-16."""

from __future__ import annotations

from typing import Any

from tests.ls.client import QUIET, Client, place, span

URI = "file:///dance.improv"
DOCUMENT = {"textDocument": {"uri": URI}}
REFRESHED = {"workspace": {"inlayHint": {"refreshSupport": True}, "codeLens": {"refreshSupport": True}}}
PROGRAM = "# 🐢\r\nbeat 30\r\n𝑥 = [up [left 𝑦]]\r\n𝑧 = [up [left right]]\r\nr $ 𝑧\r\ns $ repeat up\r\n"
WHOLE = span(0, 0, 0, last=9)


def hints(client: Client, seen: dict[str, Any] = WHOLE) -> list[tuple[int, int, str]]:
    found = client.request("textDocument/inlayHint", {**DOCUMENT, "range": seen})
    return [(each["position"]["line"], each["position"]["character"], each["label"]) for each in found]


def lenses(client: Client) -> list[tuple[int, str, str, list[Any]]]:
    found = client.request("textDocument/codeLens", DOCUMENT)
    commands = [(each["range"]["start"]["line"], each["command"]) for each in found]
    return [(line, each["title"], each["command"], each["arguments"]) for line, each in commands]


def test_beats_are_shown_to_editors_that_want_them() -> None:
    with Client({"onSave": "off"}, capabilities=REFRESHED) as client:
        client.open(URI, PROGRAM)
        assert hints(client) == []
        client.set(inlayHints={"beats": True})
        client.wait("workspace/inlayHint/refresh")
        assert hints(client) == [(3, 10, "×4"), (3, 22, "1 beat"), (4, 6, "1 beat"), (5, 13, "∞")]
        line = span(4, 0, 6)
        assert hints(client, line) == [(4, 6, "1 beat")]
        client.set(inlayHints={"beats": True}, codeLens=True)
        client.set(inlayHints={"beats": False})
        client.wait("workspace/inlayHint/refresh")
        assert hints(client) == []
        assert not any(each["method"].endswith("/refresh") for each in client.notifications)


def test_lines_that_play_show_their_beat_in_editors_that_want_it() -> None:
    with Client(QUIET, capabilities=REFRESHED) as client:  # nothing else shows it what plays
        client.open(URI, "beat 240\r\nr $ 𝑥\r\n")
        client.change(URI, 2, {"text": "beat 120\r\n𝑥 = repeat up\r\nr $ 𝑥\r\n"})
        assert hints(client) == []
        client.save(URI)
        client.wait_for_line("▶")
        seen: list[str] = []
        while len(seen) < 2:  # beats, one after the other
            client.wait("workspace/inlayHint/refresh")
            found = hints(client)
            assert [(line, column) for line, column, _ in found] in ([], [(2, 6)])
            seen += [text for _, _, text in found if text not in seen]
        assert all(text.startswith("beat ") and text.endswith("/∞") for text in seen)
        assert hints(client, span(0, 0, 0, last=1)) == []
        client.command("stop")
        while hints(client):
            client.wait("workspace/inlayHint/refresh")


def test_an_editor_that_lights_up_words_shows_no_beats_unless_somebody_wants_them() -> None:
    with Client(QUIET, capabilities={**REFRESHED, "experimental": {"improv": True}}) as client:
        client.play(URI, "r $ repeat up\n")
        client.wait("improv/lit")
        assert hints(client) == []
        client.set(inlayHints={"playing": True})
        client.wait("workspace/inlayHint/refresh")
        assert hints(client)


def test_a_program_and_its_scenes_say_how_long_they_take() -> None:
    with Client({"onSave": "off"}, capabilities=REFRESHED) as client:
        client.open(URI, "# 🐢\r\nr $ up\r\n---\r\ns $ up left\r\n")
        scene = {"from": 2, "to": 2}
        both: list[tuple[int, str, str, list[Any]]] = [(0, "▶ play · 3 beats, 3.0 s", "improv.play", [URI])]
        both += [(2, "▶ scene 2 · 2 beats, 2.0 s", "improv.play", [URI, scene])]
        assert lenses(client) == both
        # A scene gets its own with the next save: otherwise it would move the line that a person types.
        client.change(URI, 2, {"text": "# 🐢\r\nr $ up\r\n---\r\ns $ up left\r\n---"})
        assert lenses(client) == [*both, (2, "▶ from here", "improv.play", [URI, {"from": 2, "to": 3}])]
        client.save(URI)
        client.wait("workspace/codeLens/refresh")
        assert [title for _, title, _, _ in lenses(client)][2:] == ["▶ from here", "▶ scene 3 · 0 beats, 0.0 s"]
        client.set(codeLens=False)
        client.wait("workspace/codeLens/refresh")
        assert lenses(client) == []


def test_a_line_inside_brackets_is_indented_as_it_is_typed() -> None:
    def typed(line: int, column: int, key: str) -> list[tuple[int, int, int, str]]:
        asked = place(URI, line, column, ch=key, options={"tabSize": 8, "insertSpaces": False})
        edits = client.request("textDocument/onTypeFormatting", asked)
        places = [(each["range"]["start"], each["range"]["end"], each["newText"]) for each in edits]
        return [(start["line"], start["character"], end["character"], text) for start, end, text in places]

    with Client({"onSave": "off"}) as client:
        offered = client.initialized["capabilities"]["documentOnTypeFormattingProvider"]
        assert offered == {"firstTriggerCharacter": "\n", "moreTriggerCharacter": [")", "]"]}
        client.open(URI, "# 🐢\r\n𝑥 = (𝑥 [up # 🐢\r\n\t\r\n    ]\r\n    𝑥)\r\n")
        assert typed(2, 1, "\n") == [(2, 0, 1, "    ")]
        assert typed(3, 5, "]") == [(3, 0, 4, "  ")]
        assert typed(4, 7, ")") == []
        assert typed(5, 0, "\n") == []
