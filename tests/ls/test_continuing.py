"""Messages to an editor when a save edits the dance that plays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from improv_ls import editor
from improv_ls.offers import HINT, OFFER
from tests.ls.client import QUIET, TOLD, Client

URI = "file:///dance.improv"
BEFORE = "beat 480\nanna $ repeat (forward left)\nbert $ repeat forward\n"
AFTER = "# more\n" + BEFORE.replace("bert $ repeat forward", "bert $ repeat left")


def told(client: Client, generation: int, state: str) -> Any:
    """Wait for the transport message that reports this state of a score."""
    return client.wait(
        "improv/transport", lambda params: (params["generation"], params["state"]) == (generation, state)
    )


def test_words_are_lit_from_the_beat_at_which_they_take_over() -> None:
    with Client({**QUIET, "onSave": "continue", "switchAt": "bar", "beatsPerBar": 6}, TOLD) as client:
        client.open(URI, BEFORE)
        client.save(URI)
        client.wait("improv/lit", lambda params: params["ranges"] == [[1, 15, 1, 22], [2, 14, 2, 21]])
        told(client, 1, "playing")
        client.wait("improv/transport", lambda params: params["beat"] > 2)
        client.change(URI, 2, {"text": AFTER})
        client.save(URI)
        lit = client.wait("improv/lit", lambda params: [3, 14, 3, 18] in params["ranges"])
        assert (lit["uri"], lit["version"]) == (URI, 2)
        assert told(client, 2, "playing")["beat"] >= 6
        client.wait("improv/lit", lambda params: params["ranges"] == [[2, 23, 2, 27], [3, 14, 3, 18]])
        client.wait("improv/lit", lambda params: params["ranges"] == [[2, 15, 2, 22], [3, 14, 3, 18]])


@pytest.mark.parametrize(("given", "hints"), [({}, 1), ({"onSave": "restart"}, 0), ({"onSave": "continue"}, 0)])
def test_the_first_save_that_restarts_a_dance_mentions_continue(state: Path, given: dict[str, str], hints: int) -> None:
    for session in range(2):
        with Client({**QUIET, **given}, TOLD) as client:
            client.open(URI, BEFORE)
            for generation in range(1, 4):
                client.save(URI)
                told(client, generation, "playing")
            client.request("workspace/symbol", {"query": ""})
        assert offers(client) == (0 if session else hints)  # it is remembered


def test_the_beat_leaves_the_hint_where_both_share_a_line(monkeypatch: pytest.MonkeyPatch, state: Path) -> None:
    monkeypatch.setattr(editor, "READING", 60.0)
    with Client(QUIET, {**TOLD, "window": {"workDoneProgress": True}}) as client:
        client.open(URI, BEFORE)
        client.save(URI)
        client.wait("$/progress", lambda params: params["value"]["kind"] == "report")
        client.save(URI)
        client.wait_for_line(HINT)
        client.wait("improv/transport", lambda params: params["generation"] == 2 and params["beat"] > 4)
        sent = [each.message for each in client.log if each.by_server]
        hint = next(at for at, each in enumerate(sent) if HINT in str(each))
        kinds = [each["params"]["value"]["kind"] for each in sent[hint:] if each.get("method") == "$/progress"]
        assert set(kinds) <= {"end"}


def offers(client: Client) -> int:
    shown = [each.message for each in client.log if each.by_server and "method" in each.message]
    return sum(text in str(each.get("params")) for each in shown for text in (HINT, OFFER))


def actions(client: Client) -> list[Any]:
    return [each for each in client.actions(URI, 1, 0) if each["kind"] == "improv.onSave"]


def test_the_choice_that_saves_continue_the_dance_outlasts_the_session(state: Path) -> None:
    with Client(QUIET, TOLD) as client:
        client.open(URI, BEFORE)
        assert actions(client) == []
        client.save(URI)
        told(client, 1, "playing")
        (action,) = actions(client)
        assert action["title"] == "Let saves continue the dance"
        client.request("workspace/executeCommand", action["command"])
        client.wait_for_line("from now on, saves continue the dance")
        continues(client, 2)
    with Client(QUIET, TOLD) as client:
        client.open(URI, BEFORE)
        client.save(URI)
        told(client, 1, "playing")
        continues(client, 2)
        (action,) = actions(client)
        assert action["title"] == "Let saves start the dance over"
        client.set(onSave="restart")
        client.command("onSave", "continue")
        client.wait_for_line("improv.onSave: the editor's settings say restart")
    assert offers(client) == 0


def test_an_editor_with_buttons_and_settings_of_its_own_sets_what_saves_do(state: Path) -> None:
    with Client(QUIET, {**TOLD, "experimental": {"improv": {"settings": True}}}) as client:
        client.presses = "Continue from Now On"
        client.open(URI, BEFORE)
        client.save(URI)
        told(client, 1, "playing")
        client.save(URI)
        assert client.wait("improv/settings") == {"onSave": "continue"}
        assert not any(OFFER in str(each.get("params")) for each in client.notifications if "id" not in each)


def continues(client: Client, generation: int) -> None:
    """Save, and see that the dance continues."""
    client.save(URI)
    message = told(client, generation, "playing")
    assert message["beat"] > 0
