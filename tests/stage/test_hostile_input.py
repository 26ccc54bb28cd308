"""A stage refuses input that it can't understand, in one line; any other trouble stops its robots and ends it."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from typing import Any

import pytest

from improv_core.ipc.arrivals import End, Unreadable
from improv_core.protocol.messages import Load, Play
from improv_core.score.json_types import as_json
from improv_core.score.motion import STILL
from improv_core.score.score_json import RowsRead, to_json
from improv_core.score.senses import BuiltIn, Key, Topic
from improv_core.stage.stdio import arrival
from tests.player.test_player import Memory, score
from tests.stage.test_loop import errors, load, perform, zeros

PROGRAM = "x = left || repeat 2 slow 2 scale 1/3 (forward reverse right)\nr $ x\n"
LOAD: Load = {
    "type": "load",
    "generation": 2,
    "score": to_json(score(PROGRAM)),
    "when": "restart",
    "backend": "memory",
    "beats_per_bar": 4,
    "entry": {"beat": 0.0, "monotonic": 1000.0, "begins": {"r": 0.0}},
    "at": 1000.0,
}
LOAD["score"]["parts"]["r"]["senses"] = as_json(
    {"near": Topic("/r/scan", "sensor_msgs/LaserScan", below=0.5), "bump": BuiltIn("bump"), "drop": Key("d")}
)
WRONG: list[Any] = [None, True, -1, 0, 10**400, 1.5, 1e999, float("nan"), "", "1/0", "-1", "9" * 3000]
WRONG += ["1e99999999", "\ud800", [], [None] * 3, {}, {"": {}}]
MOVING = load("r $ repeat forward\n")


def variants(value: Any) -> Iterator[Any]:
    """Yield copies of a JSON value, each with one thing in it replaced by something wrong, or missing."""
    yield from WRONG
    if isinstance(value, dict):
        for key in value:
            rest = {other: inner for other, inner in value.items() if other != key}
            yield rest
            yield from ({**value, key: inner} for inner in variants(value[key]))
        yield {**value, "added": 1}
    elif isinstance(value, (list, tuple)):
        for place, item in enumerate(value):
            yield [*value[:place], *value[place + 1 :]]
            yield from ([*value[:place], inner, *value[place + 1 :]] for inner in variants(item))


@pytest.mark.slow("tries every wrong value")
def test_no_wrong_value_keeps_a_robot_moving() -> None:
    """The stage refuses any bad value, or plays it and ends; and every robot has received zeros at the end."""
    seen = {Play: 0, Unreadable: 0}
    stood = {"beat": 0.0, "monotonic": 1000.0, "scene": {"index": 0, "begins": 0.0}}
    for wrong in [*variants(copy.deepcopy(LOAD)), *({**LOAD, "stood": each} for each in (stood, *variants(stood)))]:
        came = arrival(json.dumps(wrong).encode() + b"\n", RowsRead())
        if isinstance(came, (Play, Unreadable)):
            seen[type(came)] += 1
        if isinstance(came, Play):
            sink = Memory()
            told = perform(sink, (0, MOVING), (0.51, came), (3, End()))
            assert told[-1]["type"] == "stopped"
            assert [twist for name, _, twist in sink.sent if name == "r"][-3:] == [STILL] * 3, wrong
    assert seen[Unreadable] > 4 * seen[Play] > 0  # some values are right in some places


HELD = ["hold", [1, 0, 0, 0], 1, None]
VOICES = [HELD, ["hold", [0, 0, 0, 1], 1, None]]


@pytest.mark.parametrize(
    "change",
    [
        {"tempo": "1/0"},
        {"tempo": "-60"},
        {"tempo": "1e99999999"},
        {"tempo": float("nan")},
        {"movements": []},
        {"movements": [["dance"]]},
        {"movements": [HELD, *(["repeat", place, 10**9] for place in range(35))]},
        {"movements": [["hold", [1, 0, 0, 0], -1, None]]},
        {"movements": [HELD, ["series", [-1]]]},
        {"movements": [["series", [0]]]},
        {"movements": [HELD, ["until", [0], 3, True, None]]},
        {"movements": [HELD, ["until", [0], "near", 1, None]]},
        {"movements": [HELD, ["until", [0, 0], "near", True, None]]},
        {"movements": [HELD, ["if", [0], "near", True, None]]},
        {"movements": [HELD, ["pause", [0], "near", True]]},
        {"movements": [HELD, ["until", [0], "near", True, None], ["reverse", 1]]},
        {"movements": [HELD, ["until", [0], "near", True, None], ["ease", 1]]},
        {"movements": [HELD, ["until", [0], "near", True, None], ["chance", 1, "1/2", None]]},
        {"movements": [HELD, ["until", [0], "near", True, None], ["choose", [0, 1]]]},
        {"movements": [HELD, *(["until", [place], "near", True, None] for place in range(300))]},
        {"movements": [HELD, ["pace", 0, "-1"]]},
        {"movements": [*VOICES, *(["parallel", [place, place + 1]] for place in range(300))]},
    ],
)
def test_a_score_out_of_range_is_refused_and_stops_the_robots(change: dict[str, Any]) -> None:
    data = {**LOAD["score"], **change}
    data["parts"] = {"r": {**data["parts"]["r"], "scenes": [len(data["movements"]) - 1]}}
    came = arrival(json.dumps({**LOAD, "score": data}).encode(), RowsRead())
    assert isinstance(came, Unreadable)
    assert came.is_score
    sink = Memory()
    told = perform(sink, (0, MOVING), (0.51, came), (9, End()))
    (line,) = errors(told)
    assert line.startswith("this program can't be played: ")
    assert zeros(sink, "r") == [0.51, 0.56, 0.61]
