"""Requests of a page, and those that are dropped."""

from __future__ import annotations

import json
from typing import Any

import pytest

from improv_core.page.routes import MAX_BYTES
from improv_core.protocol.fields import LONGEST_TEXT
from improv_core.protocol.page_messages import read


def change(**change: Any) -> dict[str, Any]:
    return {"type": "change", "number": 1, "change": change}


RIGHT: list[dict[str, Any]] = [
    *({"type": kind} for kind in ("stop", "pause", "resume", "restart", "held", "released", "cue")),
    {"type": "press", "number": 1},
    {"type": "resume", "anyway": True},
    {"type": "key", "key": "d", "held": True},
    {"type": "force", "robot": "ada", "sense": "near", "value": True},
    {"type": "force", "robot": "ada", "sense": "near", "value": None},
    {"type": "seek", "beat": 2.5},
    {"type": "speed", "factor": 0.1},
    {"type": "silence", "muted": ["ada"] * 1000, "soloed": []},
    change(type="place", start_poses={"ada": {"x": 1, "y": -2.5, "heading": 90}, "bo": {"x": 0, "y": 0, "heading": 0}}),
    change(type="arrange", shape="circle", distance=1.5, facing="out"),
    change(type="tune", key="beat", value=96),
    {"type": "window", "generation": 3, "from": 1, "to": 1e9},
    {"type": "analyze", "number": 1, "text": "é" * LONGEST_TEXT},
    {"type": "complete", "number": 1, "offset": 0},
    {"type": "explain", "number": 1, "offset": 0},
    {"type": "preview", "number": 1, "known": 0},
    {"type": "write", "number": 1, "text": "", "revision": "0"},
]


@pytest.mark.parametrize("message", RIGHT, ids=lambda message: str(message["type"]))
def test_a_request_is_read_with_its_values_only(message: dict[str, Any]) -> None:
    added = {"at": 7, "by": "osc", "direct": "d", "page": 7, "more": "x"}
    assert read(json.dumps({**message, **added})) == message


WRONG = [
    *("", "{", "[" * 100_000, "7", "[]", "{}", '{"type": 7}', '{"type": ["stop"]}', '{"type": "load"}'),
    '{"type": "press"}',
    '{"type": "press", "number": -1}',
    '{"type": "seek"}',
    '{"type": "seek", "beat": -1}',
    '{"type": "seek", "beat": NaN}',
    '{"type": "seek", "beat": Infinity}',
    '{"type": "seek", "beat": true}',
    '{"type": "seek", "beat": "1"}',
    '{"type": "seek", "beat": 1' + "0" * 400 + "}",
    '{"type": "key", "key": "d"}',
    '{"type": "key", "key": "", "held": true}',
    '{"type": "key", "key": "d", "held": 1}',
    '{"type": "force", "robot": "ada", "sense": "near"}',
    '{"type": "force", "robot": "ada", "sense": 7, "value": true}',
    '{"type": "force", "robot": "ada", "sense": "near", "value": 1}',
    '{"type": "sensed", "robot": "ada", "sense": "near", "value": true}',
    '{"type": "speed", "factor": 0.09}',
    '{"type": "speed", "factor": 4.1}',
    '{"type": "silence", "muted": ["ada"]}',
    '{"type": "silence", "muted": "ada", "soloed": []}',
    '{"type": "silence", "muted": [""], "soloed": []}',
    json.dumps({"type": "silence", "muted": ["ada"] * 10_001, "soloed": []}),
    json.dumps({"type": "silence", "muted": ["a" * 1001], "soloed": []}),
    *map(
        json.dumps,
        [
            change(type="stop"),
            change(type="place", robot="ada", x=1, y=1, heading=0),
            change(type="place", start_poses=["ada"]),
            change(type="place", start_poses={"ada": 1}),
            change(type="place", start_poses={"ada": {"x": 1, "y": 1}}),
            change(type="place", start_poses={"ada": {"x": 1001, "y": 1, "heading": 0}}),
            change(type="place", start_poses={"": {"x": 1, "y": 1, "heading": 0}}),
            change(type="arrange", shape="ring", distance=1, facing="in"),
            change(type="arrange", shape=["line"], distance=1, facing="in"),
            change(type="arrange", shape="line", distance=0, facing="in"),
            change(type="tune", key="beat", value="fast"),
        ],
    ),
    '{"type": "window", "generation": 1, "from": 0}',
    '{"type": "window", "generation": 1, "from": -1, "to": 4}',
    '{"type": "analyze", "number": 1.0, "text": ""}',
    '{"type": "analyze", "number": -1, "text": ""}',
    '{"type": "complete", "number": 1, "offset": true}',
    '{"type": "write", "number": 1, "text": ""}',
    '{"type": "write", "number": 1, "text": "\\ud800", "revision": ""}',
    json.dumps({"type": "write", "number": 1, "text": "x" * (LONGEST_TEXT + 1), "revision": ""}),
    '{"type": "editing", "page": 1, "ask": {"type": "write", "number": 1, "text": "", "revision": ""}}',
    '{"type": "source", "path": "x", "text": "", "revision": ""}',
    '{"type": "page_opened"}',
]


def test_an_invalid_request_is_dropped() -> None:
    for message in WRONG:
        assert read(message) is None, message[:100]


def test_the_longest_text_fits_into_a_message() -> None:
    for request in ({"type": "analyze"}, {"type": "write", "revision": "0"}):
        longest = {**request, "number": 1, "text": "é" * LONGEST_TEXT}
        assert read(json.dumps(longest)) == longest
        assert len(json.dumps(longest)) + 1000 < MAX_BYTES
