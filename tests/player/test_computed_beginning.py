"""Setpoints that are computed before beat 0: robots get the same as without that."""

from __future__ import annotations

import pytest

from improv_core.player.active_parts import ComputedBeginning
from improv_core.player.player import Player
from improv_core.protocol.commands import Speed
from tests.player.plays import to_play
from tests.player.test_player import Memory, score

ROBOTS = [f"r{number}" for number in range(11)]


def check(monkeypatch: pytest.MonkeyPatch, program: str, *meanwhile: Speed) -> None:
    """Compare what robots are sent in two seconds. Messages may come before beat 0."""

    def sent() -> list[object]:
        sink = Memory()
        player = Player(sink, lambda message: None, lambda: 0.0)
        player.take(to_play(score(program)), 0.0)
        assert player.run.mode == "waiting"
        for message in meanwhile:
            player.take(message, 0.0)
        for step in range(201):
            player.advance(step / 100)
        return list(sink.sent)

    computed = sent()
    monkeypatch.setattr(ComputedBeginning, "compute", lambda beginning, run: None)
    assert len(computed) > len(ROBOTS)
    assert computed == sent()


def test_robots_get_the_same_setpoints(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch, f"beat 90\n{' '.join(ROBOTS)} $ repeat (forward left)")
    check(monkeypatch, f"beat 90\n{' '.join(ROBOTS)} $ forward\n---\nr1 $ left right")


def test_a_change_of_speed_before_beat_0_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch, f"beat 90\n{' '.join(ROBOTS)} $ repeat (forward left)", {"type": "speed", "factor": 2.0})


def test_parts_that_senses_decide_begin_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    check(monkeypatch, f"beat 90\n{' '.join(ROBOTS)} $ repeat (forward until cue left)")
