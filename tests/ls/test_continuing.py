"""Messages to an editor when a save edits the dance that plays."""

from __future__ import annotations

from typing import Any

import pytest

from improv_ls.performance import HINT
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
def test_the_first_save_that_restarts_a_dance_mentions_continue(given: dict[str, str], hints: int) -> None:
    with Client({**QUIET, **given}, TOLD) as client:
        client.open(URI, BEFORE)
        for generation in range(1, 4):
            client.save(URI)
            told(client, generation, "playing")
        client.request("workspace/symbol", {"query": ""})
        said = [each.message["params"] for each in client.log if each.message.get("method") == "window/showMessage"]
        assert sum(each["message"] == HINT for each in said) == hints
