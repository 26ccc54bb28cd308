"""Messages of the stage of real robots → the messages in the editor, and the effect of a person's answer."""

from __future__ import annotations

import json
import queue
from collections.abc import Iterator
from typing import Any

import pytest
from lsprotocol import types

from improv_core.protocol.decoding import read_as
from improv_core.protocol.messages import FromStage, Misplaced, ToStage
from tests.ls.client import LIMIT, TOLD, TURNS, Client
from tests.session.story import at
from tests.stage_on_thread import StageOnThread

URI = "file:///dances/dance.improv"
PLACE = {"x": 1.0, "y": 0.0, "z": 0.0, "heading": 0.0}
ONE = "1 robot is not in its place, so the dance doesn't begin"
TWO = "2 robots are not in their places, so the dance doesn't begin"
BUTTONS = {**TOLD, "experimental": {"improv": {"settings": True}}}
"""Capabilities of a client whose buttons are in nobody's way."""
FAULT = {"robot": "r", "fault": "gone", "worst": {}, "generation": 1, "beat": 0.0, "performed": 0.0, "wall": 0}


class Stages:
    """The stages that were started, and all messages to them."""

    def __init__(self) -> None:
        self.started: list[StageOnThread] = []
        self.sent: queue.SimpleQueue[ToStage] = queue.SimpleQueue()

    def say(self, message: Any, times: int = 1) -> None:
        """Send this message from the latest stage, as one of real robots would, with no other message in between."""
        stage = self.started[-1]
        heard = read_as(json.dumps(message).encode(), FromStage)

        def tell() -> None:
            for _ in range(times):
                stage._told(heard, 0)

        stage._loop.call_soon_threadsafe(tell)

    def silence(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Drop what the latest stage reports by itself: it plays, and its reports would come in between."""
        monkeypatch.setattr(self.started[-1], "_soon", lambda *_: None)

    def asked(self, client: Client) -> list[str]:
        """Return the requests since the last call. An answer to a message takes a few turns to have effect, so the
        client sends as many other requests meanwhile."""
        kinds = list[str]()
        for _ in range(TURNS):
            client.command("cue")
            while (message := self.sent.get(timeout=LIMIT))["type"] != "cue":
                if message["type"] == "resume":
                    kinds.append("anyway" if message.get("anyway") else f"resume {message.get('beat', '')}".strip())
        return kinds


@pytest.fixture
def stages(monkeypatch: pytest.MonkeyPatch) -> Stages:
    stages, start, send = Stages(), StageOnThread.__init__, StageOnThread.send

    def started(stage: StageOnThread, *arguments: Any) -> None:
        start(stage, *arguments)
        stages.started.append(stage)

    def sent(stage: StageOnThread, message: ToStage) -> None:
        stages.sent.put(message)
        send(stage, message)

    monkeypatch.setattr(StageOnThread, "__init__", started)
    monkeypatch.setattr(StageOnThread, "send", sent)
    return stages


@pytest.fixture
def client(stages: Stages) -> Iterator[Client]:
    """A client with buttons that plays a program."""
    with Client({"backend": "sim"}, BUTTONS) as client:
        client.play(URI, "r s $ repeat forward\n")
        yield client


def misplaced(*robots: str, waits: bool = True) -> Misplaced:
    found: Any = {robot: {"place": PLACE, "pose": None, "line": f"move {robot}"} for robot in robots}
    return {"type": "misplaced", "generation": 1, "waits": waits, "robots": found}


def offers(client: Client) -> list[str]:
    """Return the messages with a button, as far as they have come. Earlier requests have had their effect by then."""
    client.command("cue")
    asked = (each.message for each in client.log if each.message.get("method") == "window/showMessageRequest")
    return [each["params"]["message"] for each in asked]


def test_the_button_of_a_message_begins_anyway(stages: Stages, client: Client) -> None:
    client.presses = "Begin anyway"
    stages.say(misplaced("r"))
    asked = client.wait("window/showMessageRequest")
    assert (asked["message"], asked["actions"]) == (ONE, [{"title": "Begin anyway"}])
    assert stages.asked(client) == ["anyway"]


def test_closing_a_message_begins_nothing(stages: Stages, client: Client) -> None:
    stages.say(misplaced("r", "s"))
    assert client.wait("window/showMessageRequest")["message"] == TWO
    assert stages.asked(client) == []


def test_people_are_asked_once_until_robots_no_longer_have_to_be_put_in_place(stages: Stages, client: Client) -> None:
    """Poses that come while people move robots there cause no new message."""
    for message in (misplaced("r", "s"), misplaced("r"), misplaced(), misplaced("s")):
        stages.say(message)
    client.wait("window/showMessageRequest")
    assert offers(client) == [TWO]
    for message in (misplaced(waits=False), misplaced("s")):
        stages.say(message)
    client.wait("window/showMessageRequest")
    assert offers(client) == [TWO, ONE]


def test_a_stop_voids_a_button_that_was_shown_before(stages: Stages) -> None:
    with Client({"backend": "sim"}, BUTTONS, answers=False, configuration={"backend": "sim"}) as client:
        client.play(URI, "r s $ repeat forward\n")
        client.presses = "Begin anyway"
        stages.say(misplaced("r"))
        client.wait("window/showMessageRequest")
        client.command("stop")
        client.answer_late()
        assert stages.asked(client) == []


@pytest.mark.parametrize(("presses", "beat"), [("From beat 3", 2.0), ("From beat 4", 3.5), ("", None)])
def test_buttons_resume_after_a_stop_that_nobody_asked_for(
    presses: str, beat: float | None, stages: Stages, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    client.presses = presses
    stages.silence(monkeypatch)
    stages.say(at("stopped", 1, resumes={"scene": 2.0, "beat": 3.5}, beats=0.0), times=2)
    asked = client.wait("window/showMessageRequest")
    assert [each["title"] for each in asked["actions"]] == ["From beat 3", "From beat 4"]
    assert offers(client) == ["Robots were stopped: resume from this scene, or this beat?"]
    assert stages.asked(client) == ([f"resume {beat}"] if beat is not None else [])


def test_an_editor_whose_prompt_would_take_keys_has_code_actions_that_resume(
    stages: Stages, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Client({"backend": "sim"}) as client:
        client.play(URI, "r s $ repeat forward\n")
        client.command("resume", 2.0)
        client.wait_for_line("improv.resume: robots can't resume from there now")
        assert resuming(client) == []
        stages.silence(monkeypatch)
        stages.say(misplaced("r"))
        client.wait_for_line(f"{ONE}; improv.anyway begins it")
        stages.say(at("stopped", 1, resumes={"scene": 2.0, "beat": 3.5}, beats=8.0))
        client.wait_for_line("Robots were stopped: resume by the code actions")
        scene, beat = resuming(client)
        assert (scene["title"], beat["title"]) == ("Resume from this scene", "Resume from this beat")
        client.request("workspace/executeCommand", scene["command"])
        assert stages.asked(client) == ["resume 2.0"]
        assert offers(client) == []


def resuming(client: Client) -> list[Any]:
    return [each for each in client.actions(URI, 0, 0) if each["kind"] == "improv.resume"]


def test_a_command_begins_anyway(stages: Stages, client: Client) -> None:
    client.command("anyway")
    assert stages.asked(client) == ["anyway"]


@pytest.mark.parametrize(
    ("known", "kind"),
    [
        ({"over": False, "response": "tell"}, types.MessageType.Warning),
        ({"over": False, "response": "stand"}, types.MessageType.Warning),
        ({"over": False, "response": "stop"}, types.MessageType.Error),
        ({"over": True, "response": "stop"}, types.MessageType.Info),
    ],
)
def test_a_fault_is_shown_as_serious_as_it_is(
    stages: Stages, client: Client, known: Any, kind: types.MessageType
) -> None:
    stages.say({"type": "fault", **FAULT, **known, "message": "beat 1: r is gone", "line": ""})
    stages.say({"type": "fault", **FAULT, **known, "message": "beat 2: s is gone", "line": "beat 2: r and s are gone"})
    shown = client.wait("window/showMessage", lambda params: "beat" in params["message"])
    assert (shown["message"], shown["type"]) == ("beat 2: r and s are gone", kind)
