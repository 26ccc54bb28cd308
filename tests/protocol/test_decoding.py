"""JSON in pieces is the same JSON."""

from __future__ import annotations

import json
from typing import Any

import pytest

from improv_core.protocol.decoding import LONG, dumps, loads

FILLER = "x" * LONG


@pytest.mark.parametrize(
    "value",
    [
        [FILLER],
        {"a": FILLER, "b": {}, "c": [], "d": {"e": [["hold", [1, "1/2"], None], {"é\n": "\u2028"}]}, "f": True},
        {"score": {"movements": [["hold", [1, 0], 1.5, None]] * 9, "parts": {"r": {"scenes": [1]}}}, "x": FILLER},
    ],
)
def test_json_written_in_pieces_is_read_in_pieces(value: Any) -> None:
    assert dumps(value).decode() == json.dumps(value)
    assert loads(dumps(value)) == value
    assert loads(json.dumps(value, indent=3).encode() + b" \r\n") == value


@pytest.mark.parametrize(
    "text", ["[1", "[1,", "[1,]", '{"a"', '{"a":', '{"a":1', '{"a":1,}', "{1:1}", '{"a" 1}', "[1]]", "[1] 2", "[", "{"]
)
def test_broken_json_is_refused(text: str) -> None:
    for read in (json.loads, loads):
        with pytest.raises(ValueError):  # noqa: PT011 (whatever it says)
            read(b" " * LONG + text.encode())
