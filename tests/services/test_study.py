"""The study log: the table of its events, what is no event, and how far robots move."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from improv_core.protocol.messages import Sent
from improv_core.storage.study import HEADINGS, Distances, Noted, append, cells, read, rows, total

MILLISECOND = 1_000_000


def event(line: str) -> str:
    """A line of a log, written `SESSION TIME KIND FIELD=VALUE…`."""
    session, time, kind, *fields = line.split()
    values: dict[str, Any] = {name: value for name, _, value in (field.partition("=") for field in fields)}
    if kind == "moved":
        values = {"meters": {robot: float(far) for robot, far in values.items()}}
    else:
        values = {"program": "a.improv", **values}
    if kind == "save":
        values["errors"] = int(values["errors"])
    elif kind == "error":
        values |= {"code": "syntax", "line": 1}
    elif kind == "play":
        values["robots"] = 1
    return json.dumps({"time": float(time), "session": session, "event": kind, **values})


def check(log: str, table: str) -> None:
    found = rows(each for each in read(event(line) for line in log.strip().splitlines()) if each)
    lines = [HEADINGS, *map(cells, [*found, total(found)])]
    assert [list(cells) for cells in lines[1:]] == [line.split() for line in table.strip().splitlines()]


def test_a_session() -> None:
    check(
        """
        s 100 save errors=0
        s 100 play by=save
        s 130 save errors=2
        s 130 error
        s 130 error
        s 135 save errors=1
        s 140 save errors=0
        s 140 play by=save
        s 150 play by=command
        s 160 save errors=1 program=b.improv
        s 219 moved anna=1.5 bert=2
        s 220 moved anna=0.5
        """,
        """
        s   2.0 5 2.5 40% 1 10.0 4.0
        all 2.0 5 2.5 40% 1 10.0 4.0
        """,
    )


def test_sessions_are_in_their_order_and_lines_in_any() -> None:
    check(
        """
        b 220 save errors=0
        b 160 save errors=1
        b 220 play by=save
        a 340 save errors=0
        a 310 save errors=1
        a 340 save errors=1
        a 346 save errors=0
        c 400 play by=command
        """,
        """
        b   1.0 2 2.0 50% 1 60.0 0.0
        a   0.6 4 6.7 0%  2 18.0 0.0
        c   0.0 0 -   -   0 -    0.0
        all 1.6 6 3.8 17% 3 30.0 0.0
        """,
    )


def test_nothing() -> None:
    check("", "all 0.0 0 - - 0 - 0.0")


@pytest.mark.parametrize(
    "line",
    [
        *("", "x", "1", "[]", "{}", "[" * 100_000),
        event("s 1 play by=me"),
        event("s 1 save errors=0").replace("0}", '"0"}'),
        event("s 1 save errors=0").replace("save", "safe"),
        event("s 1 save errors=0").replace("1.0", "Infinity"),
        event("s 1 save errors=0").replace('"s"', "1"),
        event("s 1 save errors=0").replace('"save"', '["save"]'),
        event("s 1 moved anna=NaN"),
    ],
)
def test_what_is_no_event_is_passed_over(line: str) -> None:
    fine = event("s 1 save errors=0")
    assert [bool(each) for each in read([fine, line, fine])] == [True, False, True]


def test_what_is_written_is_read(tmp_path: Path) -> None:
    log = tmp_path / "study.jsonl"
    noted = Noted(1.5, "s", {"event": "moved", "meters": {"anna": 2.0}})
    append(log, noted)
    append(log, noted)
    with log.open() as lines:
        assert [(each.time, each.session, each.event["event"]) for each in read(lines) if each] == [
            (1.5, "s", "moved")
        ] * 2


def sent(robot: str, milliseconds: int, *twist: float) -> Sent:
    return {"type": "sent", "robot": robot, "twist": twist, "wall": milliseconds * MILLISECOND}


def test_distances() -> None:
    far = Distances()
    far.add(sent("anna", 0, 0.3, 0.4, 0, 9))
    far.add(sent("bert", 0, 0, 0, 0, 1))
    far.add(sent("anna", 1000, 0.3, 0.4, 0, 9))  # again
    far.add(sent("anna", 3000, 0, -1, 0, 0))
    assert far.take() == {"anna": 1.5}
    far.add(sent("anna", 2900, 0, -1, 0, 0))  # the machine's clock was set back
    far.add(sent("bert", 9000, 0, 0, 0, 0))
    far.add(sent("anna", 3900, 0, 0, 0, 0))
    assert far.take() == {"anna": 1.0}
    far.add(sent("anna", 9000, 1, 0, 0, 0))
    assert far.take() == {}
