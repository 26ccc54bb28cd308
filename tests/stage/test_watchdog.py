"""What the parent of a stage notices, and says in one line, when that hangs, fails or ends, without ROS."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import time
from collections.abc import Iterator
from urllib.request import urlopen

import pytest

from improv_core.playback.stage_process import Heard, Stage
from improv_core.playback.stops import Stops
from improv_core.stage.protocol import END_LIMIT, HANG_LIMIT, LOADING_LIMIT, ToStage, TransportMessage
from tests.ls.client import Client
from tests.processes import descendants, wait_until_gone

LIMIT = 30.0
MARGIN = 2.0
"""Seconds that a busy machine adds."""
READY = 'print(json.dumps({"type": "ready", "protocol": 1, "sink": "fake", "real": True}), flush=True)'
PLAYING: TransportMessage = {
    "type": "transport",
    "generation": 1,
    "restarted": 0,
    "state": "playing",
    "backend": "fake",
    "tempo": 60.0,
    "speed": 1.0,
    "beats": None,
    "beat": 0.0,
    "performed": 0.0,
    "muted": [],
    "soloed": [],
    "monotonic": 0.0,
    "wall": 0.0,
}
PONG = 'print(json.dumps({**message, "type": "pong"}), flush=True)'


def stage(*lines: str) -> str:
    """A stage that says it moves robots, and runs these lines for each message, which is called `message` in them."""
    moves = f"print(json.dumps({PLAYING}), flush=True)"
    loop = ["for line in sys.stdin:", " message = json.loads(line)", *lines]
    return "\n".join(["import json, sys, time", READY, moves, *loop])


def told_of(code: str, *messages: ToStage) -> tuple[list[Heard], float]:
    """What a stage that runs this code says after it moves robots until it has ended, and the seconds to that."""

    async def listen() -> tuple[list[Heard], float]:
        told: list[Heard] = []
        gone = asyncio.Event()

        def hear(_: Stage, message: Heard, stops: int) -> None:
            if message["type"] != "transport":
                told.append(message)
            if message["type"] == "gone":
                gone.set()

        watched = await Stage.start([sys.executable, "-c", code], os.environ, hear, Stops())
        began = time.monotonic()
        for message in messages:
            watched.send(message)
        await asyncio.wait_for(gone.wait(), LIMIT)
        assert not watched.alive
        return told, time.monotonic() - began

    return asyncio.run(listen())


@pytest.mark.parametrize("hang", ["time.sleep(60)", "import subprocess; subprocess.run(['sleep', '60'])"])
def test_a_stage_that_does_not_answer_is_killed(hang: str) -> None:
    """And with it what it has started, which may hang, or keep its output open."""
    told, seconds = told_of(stage(f" {hang}"))
    assert told == [{"type": "gone", "message": f"the stage did not answer for {HANG_LIMIT} s"}]
    assert seconds < HANG_LIMIT + MARGIN


@pytest.mark.parametrize("line", ["5", "null", "[]", "{}", "{", '{"type": "pong"}'])
def test_what_a_library_prints_is_no_message(line: str) -> None:
    told, _ = told_of(stage(f" print({line!r}, flush=True)", " sys.exit(0)"), {"type": "hush"})
    assert told == [{"type": "gone", "message": "the stage exited unexpectedly"}]


def test_a_stage_may_take_long_to_get_ready_for_a_score_but_not_after_that() -> None:
    """It takes longer than it may take to answer, then answers once, then never again."""
    code = stage(
        ' if message["type"] == "load":',
        f"  time.sleep({HANG_LIMIT * 2})",
        f"  message = json.loads(sys.stdin.readline()); {PONG}",
        "  time.sleep(60)",
        f" {PONG}",
    )
    told, seconds = told_of(code, {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "fake"})
    assert [message["type"] for message in told] == ["gone"]
    assert HANG_LIMIT * 2 < seconds < HANG_LIMIT * 3 + MARGIN < LOADING_LIMIT


def test_what_a_stage_fails_of_is_in_the_line_of_its_end_and_it_may_take_its_time() -> None:
    last = '{"type": "stopped", "message": "no such topic"}'
    told, seconds = told_of(stage(f" print('{last}', flush=True); time.sleep({HANG_LIMIT * 1.5}); sys.exit(1)"))
    assert [message["type"] for message in told] == ["stopped", "gone"]
    assert told[-1] == {"type": "gone", "message": "the stage failed: no such topic"}
    assert HANG_LIMIT * 1.5 < seconds < END_LIMIT


def test_a_stage_that_rests_hears_nothing_until_it_is_needed_and_then_a_ping_first() -> None:
    code = "\n".join(
        [
            "import json, select, sys",
            READY,
            "stream = open(0, 'rb', buffering=0)",
            "while select.select([stream], [], [], 2)[0]:",
            f" message = json.loads(stream.readline()); {PONG}",
            'print(json.dumps({"type": "warning", "message": "silence"}), flush=True)',
            "kinds = [json.loads(stream.readline())['type'] for _ in range(2)]",
            'print(json.dumps({"type": "warning", "message": " ".join(kinds)}), flush=True)',
        ]
    )

    async def listen() -> list[str]:
        told: asyncio.Queue[Heard] = asyncio.Queue()
        watched = await Stage.start(
            [sys.executable, "-c", code], os.environ, lambda _, message, stops: told.put_nowait(message), Stops()
        )
        lines = []
        for _ in range(2):
            message = await asyncio.wait_for(told.get(), LIMIT)
            lines.append(str(message.get("message")))
            watched.send({"type": "hush"})
        await watched.close()
        return lines

    assert asyncio.run(listen()) == ["silence", "ping hush"]


@pytest.fixture
def client() -> Iterator[Client]:
    with Client({"backend": "sim"}) as client:
        client.open("file:///dance.improv", "r $ repeat forward\n")
        client.save("file:///dance.improv")
        client.wait_for_line("▶")
        client.wait("$/progress", lambda params: params["value"]["message"] == "beat 2/∞")
        yield client
        ours = descendants(client.process.pid)
    wait_until_gone(ours, LIMIT)


@pytest.mark.parametrize(
    ("number", "line"),
    [
        (signal.SIGKILL, "the stage exited unexpectedly: a new one is stopping the robots; save to play again"),
        (signal.SIGSTOP, "the stage did not answer for 3 s: a new one is stopping the robots; save to play again"),
    ],
    ids=["SIGKILL", "SIGSTOP"],
)
def test_a_new_simulator_takes_the_place_of_one_that_is_gone(client: Client, number: signal.Signals, line: str) -> None:
    dead = descendants(client.process.pid)
    (page,) = client.wait_for_page()
    os.kill(next(iter(dead)), number)
    client.wait_for_line(line)
    wait_until_gone(dead, LIMIT)
    client.save("file:///dance.improv")
    client.wait_for_line("▶")
    assert urlopen(page).status == 200, "the page that is open is served on"
    assert len(descendants(client.process.pid)) == 1
