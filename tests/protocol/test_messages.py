"""The limits of valid messages, and the tables in docs/protocol.md."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from improv_core.protocol.decoding import ProtocolError, by_type, read_as
from improv_core.protocol.helper_messages import FromClock, FromOsc, FromPublisher, ToOsc, ToPublisher
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.protocol.page_messages import ForPages, FromPage, ToPage
from improv_core.protocol.reader_messages import FromReader, ToReader
from improv_core.protocol.standby_messages import FromStandby, ToStandby
from improv_core.protocol.transport import counted
from tests import protocol_tables
from tests.page.conftest import transport


def test_the_tables_of_the_docs_are_those_of_the_types() -> None:
    written = protocol_tables.FILE.read_text(encoding="utf-8")
    assert written == protocol_tables.text(), "run `python -m tests.protocol_tables`"


HELPERS = [ToStandby, FromStandby, ToPublisher, FromPublisher, FromClock, ToReader, FromReader, ToOsc, FromOsc]


@pytest.mark.parametrize("union", [*HELPERS, ToStage, FromStage, ForPages, ToPage, FromPage])
def test_each_type_describes_its_messages(union: Any) -> None:
    # A class can't have a field `from`, and only classes have docstrings.
    undescribed = [each for each in by_type(union).values() if not each.__doc__ and "from" not in each.__annotations__]
    assert undescribed == []


LOAD = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "simulator"}
READY = {"type": "ready", "protocol": 3, "sink": "simulator", "real": False}
PLACE = {"type": "place", "start_poses": {"r": {"x": 1, "y": 2, "heading": 90.0}}}
MOVE = {"type": "change", "number": 0, "change": PLACE}


@pytest.mark.parametrize(
    ("union", "message"),
    [
        (ToStage, {**LOAD, "zero": 1}),
        (ToStage, {"type": "stop"}),
        (ToStage, {"type": "seek", "beat": 1, "at": 2.5}),
        (ToStage, {"type": "seek", "beat": 1.5, "added_later": None}),
        (ToStage, {"type": "silence", "muted": [], "soloed": ["r"]}),
        (FromStage, {**READY, "page": "http://127.0.0.1:1/"}),
        (FromStage, {"type": "request", "command": {"type": "page_opened"}}),
        (FromStage, {"type": "request", "command": {"type": "editing", "page": 1, "ask": MOVE}}),
        (FromStage, {"type": "stopped", "poses": {"r": {"x": 0, "y": 0, "z": 0, "heading": 0}}}),
        (FromStage, {"type": "sent", "robot": "r", "twist": [0.0, 0.0, 0.0, 1.5], "wall": 1}),
    ],
)
def test_a_message_arrives_as_it_was_sent(union: Any, message: dict[str, Any]) -> None:
    assert read_as(json.dumps(message).encode(), union) == message


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("{", "this line is not JSON"),
        ("[" * 100_000, "this line is not JSON"),
        ("[1]", "this line is JSON, but not a message: it has no `type`"),
        ('{"type": 1}', "this line is JSON, but not a message: it has no `type`"),
        ('{"type": "dance"}', "there is no message `dance`"),
        ('{"type": "ready"}', "there is no message `ready`"),
        ('{"type": "load", "generation": 1}', "`load` needs `backend` and `score` and `when`"),
        ('{"type": "seek", "beat": NaN}', "`beat` of `seek` has a wrong value"),
        ('{"type": "seek", "beat": true}', "`beat` of `seek` has a wrong value"),
        ('{"type": "seek", "beat": "1"}', "`beat` of `seek` has a wrong value"),
        ('{"type": "stop", "at": null}', "`at` of `stop` has a wrong value"),
        ('{"type": "silence", "muted": [1], "soloed": []}', "`muted` of `silence` has a wrong value"),
        (json.dumps({**LOAD, "when": "later"}), "`when` of `load` has a wrong value"),
        (json.dumps({**LOAD, "generation": 1.5}), "`generation` of `load` has a wrong value"),
        (json.dumps({**LOAD, "score": []}), "`score` of `load` has a wrong value"),
    ],
)
def test_anything_else_is_refused_with_the_reason(line: str, problem: str) -> None:
    with pytest.raises(ProtocolError, match=f"^{re.escape(problem)}$"):
        read_as(line.encode(), ToStage)


@pytest.mark.parametrize(
    "command",
    [{}, {"type": "dance"}, {"type": "seek"}, {"type": "editing", "page": 1, "ask": {"type": "change"}}],
)
def test_a_request_of_unknown_form_is_refused(command: dict[str, Any]) -> None:
    with pytest.raises(ProtocolError, match="`command` of `request` has a wrong value"):
        read_as(json.dumps({"type": "request", "command": command}).encode(), FromStage)


@pytest.mark.parametrize(
    ("beat", "beats", "bar", "expected"),
    [
        (0.0, 8.0, None, "beat 1/8"),
        (2.75, 8.0, None, "beat 3/8"),
        (7.5, 7.5, None, "beat 8/8"),
        (8.0, 8.0, None, "beat 8/8"),
        (0.0, 0.0, None, "beat 1/1"),
        (41.0, None, None, "beat 42/∞"),
        (0.0, 8.0, 3, "bar 1, beat 1"),
        (2.75, 8.0, 3, "bar 1, beat 3"),
        (3.0, None, 3, "bar 2, beat 1"),
        (7.5, 7.5, 3, "bar 3, beat 2"),
        (9.0, 9.0, 3, "bar 3, beat 3"),
    ],
)
def test_beats_are_counted_from_one_in_the_bars_of_the_program(
    beat: float, beats: float | None, bar: int | None, expected: str
) -> None:
    told = transport(1, "playing", beats)
    if bar:
        told["bar"] = bar
    assert counted(told, beat) == expected
