"""What an editor shows between words and lines, and where it indents what is typed; columns in UTF-16."""

from __future__ import annotations

from typing import Any

from tests.ls.client import Client

URI = "file:///dance.improv"
DOCUMENT = {"textDocument": {"uri": URI}}
REFRESHED = {"workspace": {"inlayHint": {"refreshSupport": True}, "codeLens": {"refreshSupport": True}}}
PROGRAM = "# 🐢\r\nbeat 30\r\n𝑥 = [up [left 𝑦]]\r\n𝑧 = [up [left right]]\r\nr $ 𝑧\r\ns $ repeat up\r\n"
WHOLE = {"start": {"line": 0, "character": 0}, "end": {"line": 9, "character": 0}}


def set_to(client: Client, **settings: object) -> None:
    client.notify("workspace/didChangeConfiguration", {"settings": {"improv": settings}})


def hints(client: Client, seen: dict[str, Any] = WHOLE) -> list[tuple[int, int, str]]:
    found = client.request("textDocument/inlayHint", {**DOCUMENT, "range": seen})
    return [(each["position"]["line"], each["position"]["character"], each["label"]) for each in found]


def lenses(client: Client) -> list[tuple[int, str, str, list[str]]]:
    found = client.request("textDocument/codeLens", DOCUMENT)
    commands = [(each["range"]["start"]["line"], each["command"]) for each in found]
    return [(line, each["title"], each["command"], each["arguments"]) for line, each in commands]


def test_beats_are_shown_to_those_who_want_them() -> None:
    with Client({"onSave": "off"}, capabilities=REFRESHED) as client:
        client.open(URI, PROGRAM)
        assert hints(client) == []
        set_to(client, inlayHints={"beats": True})
        client.wait("workspace/inlayHint/refresh")
        assert hints(client) == [(3, 10, "×4"), (3, 22, "1 beat"), (4, 6, "1 beat"), (5, 13, "∞")]
        line = {"start": {"line": 4, "character": 0}, "end": {"line": 4, "character": 6}}
        assert hints(client, line) == [(4, 6, "1 beat")]
        set_to(client, inlayHints={"beats": True}, codeLens=True)
        set_to(client, inlayHints={"beats": False})
        client.wait("workspace/inlayHint/refresh")
        assert hints(client) == []
        assert not any(each["method"].endswith("/refresh") for each in client.notifications)


def test_lines_that_play_show_their_beat_to_those_who_want_it() -> None:
    settings = {"backend": "sim", "page": {"open": False}, "inlayHints": {"playing": True}}
    with Client(settings, capabilities=REFRESHED) as client:
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
        assert hints(client, {"start": {"line": 0, "character": 0}, "end": {"line": 1, "character": 0}}) == []
        client.request("workspace/executeCommand", {"command": "improv.hush", "arguments": []})
        while hints(client):
            client.wait("workspace/inlayHint/refresh")


def test_lines_that_play_say_what_can_be_done_with_them() -> None:
    with Client({"onSave": "off"}, capabilities=REFRESHED) as client:
        client.open(URI, PROGRAM.replace("𝑥 =", "# 𝑥 ="))
        head = {"start": {"line": 4, "character": 0}, "end": {"line": 4, "character": 3}}
        below = {"start": {"line": 5, "character": 0}, "end": {"line": 5, "character": 3}}
        name = {"start": {"line": 3, "character": 0}, "end": {"line": 3, "character": 4}}
        assert lenses(client) == [
            (3, "▶ try · 1 beat, 2.0 s", "improv.play", [URI, name]),
            (4, "▶ this line · 1 beat, 2.0 s", "improv.play", [URI, head]),
            (4, "▶ play all", "improv.play", [URI]),
            (4, "■ hush", "improv.hush", []),
            (4, "mute", "improv.mute", ["r"]),
            (4, "solo", "improv.solo", ["r"]),
            (5, "▶ this line · ∞", "improv.play", [URI, below]),
            (5, "▶ play all", "improv.play", [URI]),
            (5, "■ hush", "improv.hush", []),
            (5, "mute", "improv.mute", ["s"]),
            (5, "solo", "improv.solo", ["s"]),
        ]
        set_to(client, codeLens=False)
        client.wait("workspace/codeLens/refresh")
        assert lenses(client) == []


def test_a_lens_does_what_it_says_and_then_says_something_else() -> None:
    with Client({"backend": "sim", "page": {"open": False}}, capabilities=REFRESHED) as client:
        client.open(URI, "r $ repeat up\r\ns $ repeat up\r\n")
        _, play, _, mute, *_ = client.request("textDocument/codeLens", DOCUMENT)
        client.request("workspace/executeCommand", play["command"])
        client.wait_for_line("▶ r ∞ · s ∞")
        client.request("workspace/executeCommand", {"command": "improv.pause", "arguments": []})
        client.request("workspace/executeCommand", mute["command"])
        client.wait("workspace/codeLens/refresh")
        titles = [title for _, title, _, _ in lenses(client)]
        both = ["▶ this line · ∞", "▶ play all", "■ hush"]
        assert titles == [*both, "unmute", "solo", *both, "mute", "solo"]


def test_a_line_inside_brackets_is_indented_as_it_is_typed() -> None:
    def typed(line: int, column: int, key: str) -> list[tuple[int, int, int, str]]:
        position = {"line": line, "character": column}
        options = {"tabSize": 8, "insertSpaces": False}
        params = {**DOCUMENT, "position": position, "ch": key, "options": options}
        edits = client.request("textDocument/onTypeFormatting", params)
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
