"""The timeline of a part that senses decide: the performed movements, and then the next ones if nothing changes."""

from __future__ import annotations

import pytest

from improv_core.preview.window import window
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.movement import near
from improv_core.score.replay import Replay

ROAMER = "ada $ repeat (until near (repeat forward) left)\n"
WAITER = "ada $ until cue (repeat rest) forward\n"
TURNER = "ada $ repeat (if near left else forward)\n"
Edge = tuple[str, bool | None, float]
FREE: Edge = "near", False, 0


def replay(program: str, sensed: list[Edge]) -> Replay:
    made = Replay(score_of(analyze(program)))
    for sense, value, beat in sensed:
        made.sense("ada", sense, value, near(beat))
    return made


@pytest.mark.parametrize(
    ("program", "sensed", "start", "expected"),
    [
        (ROAMER, [], 0, "0 stands, 1 stands, 2 stands, 3 stands"),
        (ROAMER, [FREE], 0, "0 forward, 1 forward, 2 forward, 3 forward"),
        (ROAMER, [FREE, ("near", True, 1.5)], 0, "0 forward, 1 forward, 1.5 until, 2 left, 3 until"),
        (ROAMER, [FREE, ("near", True, 1.5), ("near", False, 1.75)], 2, "2 left, 3 forward"),
        (WAITER, [("cue", True, 1.5)], 0, "0 rest, 1 rest, 1.5 until, 2 forward"),
        (WAITER, [("cue", True, 1.5)], 3, ""),
        (TURNER, [FREE, ("near", True, 2)], 0, "0 forward, 1 forward, 2 left, 3 left"),
        (TURNER, [FREE, ("near", None, 2)], 0, "0 forward, 1 forward, 2 stands, 3 stands"),
    ],
)
def test_a_window_shows_decisions_of_senses(program: str, sensed: list[Edge], start: float, expected: str) -> None:
    stretch = window(replay(program, sensed), start, 4)["ada"]
    shown = []
    for at, _, *velocity, words in stretch["moments"]:
        _, begin, end = words[-1] if words else (0, 0, 0)
        shown.append(f"{at:g} {program[begin:end] or 'stands'}")
        assert words or not any(velocity)
    assert ", ".join(shown) == expected


def test_a_window_begins_at_the_robots_ideal_place() -> None:
    sensed: list[Edge] = [FREE, ("near", True, 1.5), ("near", False, 2.5)]
    (x, y, _, heading), later = (window(replay(ROAMER, sensed), start, 9)["ada"]["pose"] or [] for start in (1.75, 4))
    assert (x, y, heading) == (3, 0, 0)
    assert later == pytest.approx([3, 2, 0, 1.5707963])
