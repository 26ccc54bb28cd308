"""What a stage can't understand is refused in a line; whatever else happens to its reader ends it, robots first."""

from __future__ import annotations

import copy
import json
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from improv_core import stage
from improv_core.score import senses
from improv_core.score.motion import STILL
from improv_core.score.score_json import Read, to_json
from improv_core.score.senses import BuiltIn, Key, Topic
from improv_core.stage.loop import End, Play, Unreadable
from improv_core.stage.pipes import LONGEST, arrival
from improv_core.stage.protocol import Load
from tests.stage.test_loop import errors, load, perform
from tests.stage.test_player import Memory, score
from tests.stage.test_process import LIMIT, Process

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
LOAD["score"]["parts"]["r"]["senses"] = senses.to_json(
    {"near": Topic("/r/scan", "sensor_msgs/LaserScan", below=0.5), "bump": BuiltIn("bump"), "drop": Key("d")}
)
WRONG: list[Any] = [None, True, -1, 0, 10**9, 10**400, 1.5, -1e308, 1e999, float("nan"), "", "1/0", "-1", "9" * 3000]
WRONG += ["1e99999999", "\ud800", [], [[]], [None] * 3, {}, {"": {}}]
DEEP = 100_000


def variants(value: Any) -> Iterator[Any]:
    """Copies of a JSON value, each with one thing in it replaced by something wrong, or missing."""
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


def test_no_wrong_value_keeps_a_robot_moving() -> None:
    """Whatever is wrong: the stage refuses it, or plays it and ends; and every robot has heard zeros at the end."""
    seen = {Play: 0, Unreadable: 0}
    for wrong in variants(copy.deepcopy(LOAD)):
        came = arrival(json.dumps(wrong).encode() + b"\n", Read())
        if isinstance(came, (Play, Unreadable)):
            seen[type(came)] += 1
        if isinstance(came, Play):
            sink = Memory()
            told = perform(sink, (0, load("r $ repeat forward\n")), (0.51, came), (20, End()))
            assert told[-1]["type"] == "stopped"
            assert [twist for name, _, twist in sink.sent if name == "r"][-3:] == [STILL] * 3, wrong
    assert seen[Unreadable] > 4 * seen[Play] > 0  # some values are right in some places


HELD = ["hold", [1, 0, 0, 0], 1, None]
VOICES = [["hold", [1, 0, 0, 0], 1, None], ["hold", [0, 0, 0, 1], 1, None]]


@pytest.mark.parametrize(
    "change",
    [
        {"tempo": "1/0"},
        {"tempo": "-60"},
        {"tempo": "1e99999999"},
        {"tempo": float("nan")},
        {"movements": [["hold", [1, 0, 0, 0], -1, None]]},
        {"movements": [["hold", [1, 0, 0, 0], 1, None], ["series", [-1]]]},
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
        {"movements": [["hold", [1, 0, 0, 0], 1, None], ["pace", 0, "-1"]]},
        {"movements": [*VOICES, *(["parallel", [place, place + 1]] for place in range(300))]},
    ],
)
def test_a_score_out_of_range_is_refused_and_stops_the_robots(change: dict[str, Any]) -> None:
    data = {**LOAD["score"], **change}
    data["parts"] = {"r": {**data["parts"]["r"], "scenes": [len(data["movements"]) - 1]}}
    came = arrival(json.dumps({**LOAD, "score": data}).encode(), Read())
    assert isinstance(came, Unreadable)
    assert came.is_score
    sink = Memory()
    told = perform(sink, (0, load("r $ repeat forward\n")), (0.51, came), (9, End()))
    assert len(errors(told)) == 1
    assert [round(at, 9) for _, at, twist in sink.sent if twist == STILL] == [0.51, 0.56, 0.61]


HOSTILE = [
    b"[" * DEEP + b"]" * DEEP,
    b'{"type": "load", "score": ' + b'{"a":' * DEEP + b"1" + b"}" * DEEP + b"}",
    b'{"type": "seek", "beat": NaN}',
    b'{"type": "seek", "beat": 1e999}',
    b'{"type": "seek", "beat": 1' + b"0" * 4000 + b"}",
    b'{"type": "seek", "beat": 1' + b"0" * 5000 + b"}",
    b'{"type": "speed", "factor": Infinity}',
    b'{"type": "speed", "type": 1}',
    b'{"type": "silence", "muted": "r", "soloed": []}',
    b'{"type": "hush"\xff}',
    b"\x00\x00\x00\x00",
    b"\xff\xfe",
    b'{"type": "' + b"x" * 100_000 + b'"}',
]


@pytest.fixture
def process() -> Iterator[Process]:
    process = Process()
    process.play("r $ repeat forward\n")
    yield process
    process.process.kill()
    process.process.wait(LIMIT)


def test_a_stage_refuses_every_hostile_line_and_still_obeys(process: Process) -> None:
    for number, line in enumerate(HOSTILE):
        process.write(line + b"\n")
        assert len(process.wait("error")["message"]) < 1_000
        process.write(b'{"type": "ping", "number": %d}\n' % number)  # only now: answers to pings overtake errors
        assert process.wait("pong")["number"] == number
    process.write(b'{"type": "hush"}\n')
    assert process.wait("transport")["state"] == "stopped"


def test_a_line_without_an_end_stops_the_robots_and_what_follows_is_obeyed(process: Process) -> None:
    piece = b"x" * 1_000_000
    for _ in range(LONGEST // len(piece) + 36):
        process.write(piece)
    process.write(b"\n")
    assert process.wait("error")["message"] == "this program can't be played: it is longer than 64 MB"
    assert process.wait("transport")["state"] == "stopped"
    process.write(b'{"type": "ping", "number": 1}\n')  # only now: answers to pings overtake other messages
    process.wait("pong")


def test_an_input_that_fails_ends_the_stage_which_stops_the_robots() -> None:
    listener = socket.create_server(("127.0.0.1", 0))
    ours = socket.create_connection(listener.getsockname())
    theirs, _ = listener.accept()
    command = [sys.executable, str(Path(stage.__file__).parent), "--sink", "simulator"]
    process = subprocess.Popen(command, stdin=theirs.fileno(), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    theirs.close()
    listener.close()
    assert process.stdout
    told = map(json.loads, process.stdout)
    program = {**LOAD, "score": to_json(score("r $ repeat forward\n"))}
    del program["entry"], program["at"]
    ours.sendall(json.dumps(program).encode() + b"\n")
    while next(told).get("state") != "playing":
        pass
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    ours.close()  # without a goodbye, so that reading fails
    *_, transport, stopped = told
    assert transport["state"] == "stopped"
    assert stopped["message"].startswith("the stage can't read what it is sent: ")
    output, log = process.communicate(timeout=LIMIT)
    assert (output, log, process.returncode) == (b"", b"", 1)
