"""A stage process as its parent sees it: messages on its two channels, and the line when it hangs, fails, or ends."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, Any
from unittest.mock import patch
from urllib.request import urlopen

import pytest

from improv_core.ipc.stage_process import SHORT, Heard, RunningStage, Stage
from improv_core.protocol.commands import Stop
from improv_core.protocol.messages import ToStage
from improv_core.safety import heartbeat
from improv_core.safety.heartbeat import StageWatchdog
from improv_core.safety.stops import Stops
from tests.ls.client import Client
from tests.processes import ours, wait_until_gone
from tests.session.story import at
from tests.stage_on_thread import USED

LIMIT = 60.0
SIMULATOR = "page\0--simulate"
"""A part of the command of its process."""
HANG = 0.4
"""Seconds without an answer after which a stage is killed here."""
READY = 'print(json.dumps({"type": "ready", "protocol": 3, "sink": "fake", "real": True}), flush=True)'
CHANNEL = "channel = open(int(os.environ['IMPROV_STOP_PIPE']), 'rb', buffering=0)"


def told_by(
    lines: Sequence[str], messages: Sequence[ToStage], until: Callable[[Heard], bool], hang_limit: float = LIMIT
) -> list[Heard]:
    """Return the messages of a stage that reports that it moves robots, runs these lines, and is sent messages, until
    one of its own fits."""
    moves = f"print(json.dumps({at('playing', 1)}), flush=True)"
    code = "\n".join(["import json, os, select, sys, time", CHANNEL, READY, moves, *lines])

    async def listen() -> list[Heard]:
        told: list[Heard] = []
        fits = asyncio.Event()

        def hear(_: RunningStage, message: Heard, stops: int) -> None:
            if message["type"] != "transport":
                told.append(message)
            if until(message):
                fits.set()

        stage = await Stage.start([sys.executable, "-c", code], os.environ, hear, Stops())
        for message in messages:
            stage.send(message)
        await asyncio.wait_for(fits.wait(), LIMIT)
        await stage.close()
        assert not stage.alive
        return told

    with patch.object(heartbeat, "HANG_LIMIT", hang_limit):
        return asyncio.run(listen())


def received(*messages: ToStage) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the messages from standard input, and those that had come on the channel of stops by the end of that."""
    waiting = sum(message["type"] not in ("stop", "pause") for message in messages)
    lines = [
        f"lines = [sys.stdin.readline() for _ in range({waiting})]",
        "first = []",
        "while select.select([channel], [], [], 0)[0]:",
        " first.append(channel.readline().decode())",
        'print(json.dumps({"type": "warning", "message": json.dumps([lines, first])}), flush=True)',
        "sys.stdin.read()",
    ]
    said, *_ = told_by(lines, messages, lambda message: message["type"] == "warning")
    both = json.loads(str(said.get("message")))
    return _brief(both[0]), _brief(both[1])


def _brief(lines: list[str]) -> list[dict[str, Any]]:
    messages = map(json.loads, lines)
    return [{key: each[key] for key in ("type", "after", "number") if key in each} for each in messages]


def test_a_ping_precedes_messages_that_move_robots_and_each_is_numbered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Even if the pinging thread is held up: a stage without a ping would not notice that we hang."""
    monkeypatch.setattr(StageWatchdog, "may_ping", lambda watch, now: False)
    lines, first = received({"type": "stop"}, {"type": "seek", "beat": 2.0}, {"type": "resume"}, {"type": "cue"})
    assert first == [{"type": "stop", "number": 1}, {"type": "ping", "number": 2}]
    assert lines == [{"type": "seek", "after": 1}, {"type": "resume", "after": 2}, {"type": "cue", "after": 2}]


def test_a_ping_that_has_just_been_sent_counts_for_the_next_score(monkeypatch: pytest.MonkeyPatch) -> None:
    """It wakes the stage, which would play the score later."""
    monkeypatch.setattr(StageWatchdog, "may_ping", lambda watch, now: False)
    monkeypatch.setattr("improv_core.ipc.stage_process.PING_PERIOD", LIMIT)
    score: Any = {"type": "load", "score": {}}
    lines, first = received(score, score, score)
    assert first == [{"type": "ping", "number": 1}]
    assert [(line["type"], line.get("after")) for line in lines] == [("load", 1), ("ping", None), ("load", 1)]


def test_short_messages_wait_for_long_ones_before_them() -> None:
    long: Any = {"type": "seek", "beat": 2.0, "filler": "x" * 200_000}
    score: Any = {"type": "load", "score": {"movements": [[]] * (SHORT + 1)}}
    lines, _ = received(long, {"type": "cue"}, score, {"type": "cue"})
    assert [line["type"] for line in lines] == ["seek", "cue", "load", "ping"]


@pytest.mark.parametrize("by_us", [True, False])
def test_a_stop_that_has_gone_straight_to_the_stage_is_sent_once(by_us: bool) -> None:
    """Ours or its report may come first. A stage obeys no load before it has had the stop from us."""
    stop: Stop = {"type": "stop", "direct": "x", "by": "osc"}
    report = {"type": "request", "command": stop}
    lines = [
        *(["first = [channel.readline()]"] if by_us else ["first = []"]),
        f"print(json.dumps({report}), flush=True)",
        "sys.stdin.readline()",
        "while select.select([channel], [], [], 0)[0]:",
        " first.append(channel.readline())",
        'print(json.dumps({"type": "warning", "message": b"".join(first).decode()}), flush=True)',
        "sys.stdin.read()",
    ]
    load: Any = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "ROS 2"}

    async def listen() -> str:
        stops, told = Stops(), asyncio.get_running_loop().create_future()

        def hear(stage: RunningStage, message: Heard, _: int) -> None:
            if message["type"] == "request":
                stage.send(load)
            elif message["type"] == "warning":
                told.set_result(message["message"])

        code = "\n".join(["import json, os, select, sys", CHANNEL, READY, *lines])
        stage = await Stage.start([sys.executable, "-c", code], os.environ, hear, stops)
        if by_us:
            stops.arrive(stop)
        sent = str(await asyncio.wait_for(told, LIMIT))
        await stage.close()
        return sent

    (obeyed,) = [each for each in map(json.loads, asyncio.run(listen()).splitlines()) if each["type"] == "stop"]
    assert (obeyed["direct"], obeyed["by"]) == ("x", "osc")


def test_a_start_that_is_canceled_ends_all_that_the_stage_has_started(tmp_path: Path) -> None:
    alive = tmp_path / "alive"  # the stage's child writes there as long as it runs
    os.mkfifo(alive)
    code = f"import subprocess; subprocess.run('exec sleep {LIMIT * 2} > {alive}', shell=True)"

    async def cancel() -> bytes:
        starting = asyncio.ensure_future(
            Stage.start([sys.executable, "-c", code], os.environ, lambda *_: None, Stops())
        )
        pipe = await asyncio.wait_for(asyncio.to_thread(alive.open, "rb"), LIMIT)
        starting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await starting
        with pipe:
            return await asyncio.wait_for(asyncio.to_thread(pipe.read), LIMIT)

    assert asyncio.run(cancel()) == b""


STOP: ToStage = {"type": "stop"}
LOAD: ToStage = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "fake"}
HUNG = f"the stage did not answer for {HANG} s"
NO_MESSAGES = "5", "null", "[]", "{}", "{", '{"type": "pong"}'
LAST = '{"type": "stopped", "message": "no such topic"}'


@pytest.mark.parametrize(
    ("lines", "message", "hang_limit", "reason"),
    [
        pytest.param(["import subprocess; subprocess.run(['sleep', '60'])"], STOP, HANG, HUNG, id="its child hangs"),
        pytest.param(["os.kill(os.getpid(), 19)"], STOP, HANG, HUNG, id="it is halted"),
        pytest.param(
            [
                "sys.stdin.readline()",
                f"time.sleep({HANG * 2})",
                'print(json.dumps({**json.loads(sys.stdin.readline()), "type": "pong"}), flush=True)',
                "time.sleep(60)",
            ],
            LOAD,
            HANG,
            HUNG,
            id="it takes long to load, then hangs",
        ),
        pytest.param(
            [f"print(*{NO_MESSAGES}, sep=chr(10), flush=True)", "sys.exit(0)"],
            STOP,
            LIMIT,
            "the stage exited unexpectedly",
            id="the output of a library is no message",
        ),
        pytest.param(
            [f"print('{LAST}', flush=True)", "time.sleep(1.8)", "sys.exit(1)"],
            STOP,
            1.5,
            "the stage failed: no such topic",
            id="it fails and takes long to end",
        ),
    ],
)
def test_one_line_says_why_a_stage_is_gone(
    lines: Sequence[str], message: ToStage, hang_limit: float, reason: str
) -> None:
    answers = ["while channel.readline():", *(f" {line}" for line in lines)]
    told = told_by(answers, [message], lambda message: message["type"] == "gone", hang_limit)
    assert [each for each in told if each["type"] != "stopped"] == [{"type": "gone", "message": reason}]


def test_a_page_that_is_gone_is_called_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules[__name__], "READY", READY.replace("fake", "page"))
    told = told_by(["sys.exit(0)"], [], lambda message: message["type"] == "gone")
    assert told == [{"type": "gone", "message": "the page exited unexpectedly"}]


class WithProcesses(Client):
    def _start(self, screen: bool) -> tuple[IO[bytes], IO[bytes]]:
        pipes = super()._start(screen)
        self._environment.setattr(USED, Stage)
        return pipes


def test_a_new_simulator_takes_the_place_of_one_that_is_gone() -> None:
    others = ours(SIMULATOR)
    with WithProcesses({"backend": "sim"}) as client:
        client.open("file:///dance.improv", "r $ repeat forward\n")
        client.save("file:///dance.improv")
        client.wait_for_line("▶")
        ((dead, ended),) = (each for each in ours(SIMULATOR).items() if each[0] not in others)
        (page,) = client.wait_for_page()
        os.kill(dead, signal.SIGKILL)
        client.wait_for_line("the stage exited unexpectedly: a new one is stopping the robots; play again")
        wait_until_gone({dead: ended}, LIMIT)
        client.save("file:///dance.improv")
        client.wait_for_line("▶")
        assert urlopen(page).status == 200, "the page that is open is served on"
        (new,) = ours(SIMULATOR).keys() - others
    wait_until_gone(ours(SIMULATOR), LIMIT)
    assert new != dead
