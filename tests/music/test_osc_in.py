"""Requests in OSC messages, given the known state of the dance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from improv_core.music import osc_wire
from improv_core.music.osc_in import Situation, UnclearError, request
from improv_core.protocol.play_again import STOPPED, Heard
from tests.session.story import at

PLAYS = Situation().after({**at("playing", 1), "tempo": 180.0, "speed": 1.5})
SENSING = replace(PLAYS, senses=frozenset({("kick", "anna")}))


def check(
    address: str, arguments: Sequence[Any], expected: dict[str, Any] | str | None, known: Situation = SENSING
) -> None:
    asked: Any
    try:
        asked = request(f"/improv/{address}", arguments, known)
    except UnclearError as error:
        asked = str(error)
    assert asked == expected


def test_each_address_asks_for_something() -> None:
    check("stop", [], {"type": "stop", "by": "osc"})
    check("stop", [0.0, "please"], {"type": "stop", "by": "osc"})
    check("pause", [], {"type": "pause"})
    check("cue", [], {"type": "cue"})
    check("seek", [8.5], {"type": "seek", "beat": 8.5})
    check("tempo", [60], {"type": "speed", "factor": 0.5})
    check("sense", ["kick", "anna", 1.0], {"type": "osc_sense", "name": "kick", "robot": "anna", "value": True})
    check("sense", ["kick", "anna", False], {"type": "osc_sense", "name": "kick", "robot": "anna", "value": False})


def test_a_tempo_counts_without_the_pace_of_a_clock() -> None:
    followed = Situation().after({**at("playing", 1), "tempo": 132.0, "speed": 1.0, "pace": 1.1})
    check("tempo", [60], {"type": "speed", "factor": pytest.approx(0.5)}, followed)


def test_a_button_asks_only_when_it_is_pressed() -> None:
    for address in ("cue", "pause", "play"):
        check(address, [0.0], None)
    check("cue", [1.0], {"type": "cue"})


def test_invalid_requests_are_reported() -> None:
    check("dance", [], "there is no /improv/dance")
    check("\u202egnp", [], "there is no /improv/\\u202egnp")
    wrong: list[Any]
    for wrong in ([], [-1], ["8"], [1, 2], [float("nan")], [True], [None]):
        check("seek", wrong, "/improv/seek takes a beat, counted from 0")
    for wrong in ([], [0], [481], ["fast"]):
        check("tempo", wrong, "/improv/tempo takes beats per minute, here from 12 to 480")
    for wrong in ([], ["kick", "anna"], ["kick", "anna", 0.5], ["kick", 1, 1], [None, "anna", 1]):
        check("sense", wrong, "/improv/sense takes the name of a sense, a robot, and 0 or 1")
    check("sense", ["kick", "bert", 1], "bert plays nothing that reads the OSC sense kick")


@pytest.mark.parametrize(
    ("heard", "expected"),
    [
        (Heard(None), "/improv/play: nothing has been played yet: save or play a program first"),
        (Heard("playing"), None),
        (Heard("waiting"), None),
        (Heard("waiting", armed=True), {"type": "resume", "by": "osc"}),
        (Heard("paused"), {"type": "resume", "by": "osc"}),
        (Heard("ended"), {"type": "restart", "by": "osc"}),
        (Heard("stopped"), {"type": "restart", "by": "osc"}),
    ],
)
def test_play_asks_for_what_the_state_allows(heard: Heard, expected: dict[str, Any] | str | None) -> None:
    check("play", [], expected, Situation(heard))


def test_play_reports_what_robots_wait_for_and_that_only_a_person_may_play() -> None:
    waiting = Situation().after(at("paused", 1, waits_for=["button 4 on /joy", "anna"]))
    check("play", [], "/improv/play: robots wait for button 4 on /joy and anna", waiting)
    check("play", [], f"/improv/play: {STOPPED}", Situation().after(at("stopped", 1, startable_by=["ros"])))


def test_a_pause_while_nothing_plays_asks_for_nothing() -> None:
    check("pause", [], None, Situation(Heard("ended")))


def test_written_messages_can_be_read() -> None:
    told: list[tuple[str, list[Any]]] = [
        ("/improv/beat", [8]),
        ("/improv/word", ["anna", "forward"]),
        ("/improv/far", [2**40]),
    ]
    read = osc_wire.read(osc_wire.written(told, 1.9e9))
    assert [(each.address, each.arguments) for each in read] == told
    assert {each.due for each in read} == {1.9e9}


@pytest.mark.parametrize(
    "datagram",
    [
        b"",
        b"hello",
        b"/improv/\xff\xff\0\0,s\0\0",
        b"#bundle\0",
        b"#bundle\0\0\0\0\0\0\0\0\1\x7f\xff\xff\xff/a",
    ],
)
def test_other_bytes_are_refused(datagram: bytes) -> None:
    with pytest.raises(osc_wire.BrokenError):
        osc_wire.read(datagram)
