"""What the timeline shows of a part that senses decide: what was performed, and then what comes if nothing holds."""

from __future__ import annotations

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.stage.messages import Sensed
from improv_core.stage.viewer.lookahead import window

ROAMER = "ada $ repeat (until near (repeat forward) left)\n"
WAITER = "ada $ until cue (repeat rest) forward\n"


def edge(sense: str, value: bool, beat: float) -> Sensed:
    return {
        "type": "sensed",
        "generation": 1,
        "robot": "ada",
        "sense": sense,
        "value": value,
        "beat": beat,
        "performed": beat,
        "wall": 0,
    }


@pytest.mark.parametrize(
    ("program", "sensed", "start", "expected"),
    [
        (ROAMER, [], 0, "0 forward, 1 forward, 2 forward, 3 forward"),
        (ROAMER, [("near", True, 1.5)], 0, "0 forward, 1 forward, 1.5 until, 2 left, 3 forward"),
        (ROAMER, [("near", True, 1.5), ("near", False, 1.75)], 2, "2 left, 3 forward"),
        (WAITER, [("cue", True, 1.5), ("cue", False, 1.5)], 0, "0 rest, 1 rest, 1.5 until, 2 forward"),
        (WAITER, [("cue", True, 1.5), ("cue", False, 1.5)], 3, ""),
    ],
)
def test_a_window_shows_what_senses_have_decided(
    program: str, sensed: list[tuple[str, bool, float]], start: float, expected: str
) -> None:
    stretch = window(score_of(analyze(program)), start, 4, [edge(*each) for each in sensed])["ada"]
    shown = []
    for at, *_, words in stretch["moments"]:
        _, begin, end = words[-1]
        shown.append(f"{at:g} {program[begin:end]}")
    assert ", ".join(shown) == expected


def test_a_window_begins_where_the_robot_ideally_is() -> None:
    sensed = [edge("near", True, 1.5), edge("near", False, 2.5)]
    (x, y, _, heading), later = (
        window(score_of(analyze(ROAMER)), start, 9, sensed)["ada"]["pose"] or [] for start in (1.75, 4)
    )
    assert (x, y, heading) == (3, 0, 0)
    assert later == pytest.approx([3, 2, 0, 1.5707963])
