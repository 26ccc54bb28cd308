"""A player can end any number of scenes at one moment on the small stack that a stage has."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from tests.player.test_player import QUARTER, Stage, score

USUAL = 1000
"""Python's own recursion limit, which a stage has. In this process it is higher, because programs are parsed here."""


@contextmanager
def usual_stack() -> Iterator[None]:
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(USUAL)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def test_hundreds_of_empty_scenes_end_at_once() -> None:
    stage, dance = Stage(), score("---\n" * 480 + "r $ forward")
    with usual_stack():
        stage.player.load(dance, 1, "restart", stage.now)
        stage.run(5)
    assert stage.sink.changes("r") == [(0, 0, 0), (0, 2, 0), (1, 0, 0)]
    assert stage.states == ["playing", "ended"]


def test_a_simulator_that_is_late_catches_up_with_hundreds_of_scenes() -> None:
    stage, dance = Stage(), score("---\n".join(["r $ forward\n", "r $ left\n"] * 245))
    with usual_stack():
        stage.player.load(dance, 1, "restart", stage.now)
        stage.now += 500
        stage.player.advance(stage.now)
    changes = [(float(beat), 0.0, QUARTER) if beat % 2 else (float(beat), 2.0, 0.0) for beat in range(490)]
    assert stage.sink.changes("r") == [*changes, (490, 0, 0)]
