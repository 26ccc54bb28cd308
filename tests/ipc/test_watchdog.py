"""The one line of a stage's parent when the stage hangs, fails, or ends, without ROS."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import Sequence
from typing import IO
from urllib.request import urlopen

import pytest

from improv_core.ipc.stage_process import Heard, Stage
from improv_core.protocol.messages import ToStage
from improv_core.safety.stops import Stops
from tests.ls.client import Client
from tests.processes import ours, wait_until_gone
from tests.session.story import at
from tests.stage_on_thread import USED

LIMIT = 30.0
SIMULATOR = "page\0--simulate"
"""A part of the command of its process."""
HANG = 0.4
"""Seconds without an answer after which a stage is killed here."""
READY = 'print(json.dumps({"type": "ready", "protocol": 2, "sink": "fake", "real": True}), flush=True)'
CHANNEL = "channel = open(int(os.environ['IMPROV_STOP_PIPE']), 'rb', buffering=0)"


def told_of(lines: Sequence[str], message: ToStage, hang_limit: float) -> list[Heard]:
    """Return the messages of a stage that reports that it moves robots, runs these lines when it is sent a message, and
    then has ended."""
    moves = f"print(json.dumps({at('playing', 1)}), flush=True)"
    body = [f" {line}" for line in lines]
    code = "\n".join(["import json, os, sys, time", CHANNEL, READY, moves, "while channel.readline():", *body])

    async def listen() -> list[Heard]:
        told: list[Heard] = []
        gone = asyncio.Event()

        def hear(_: Stage, message: Heard, stops: int) -> None:
            if message["type"] != "transport":
                told.append(message)
            if message["type"] == "gone":
                gone.set()

        watched = await Stage.start([sys.executable, "-c", code], os.environ, hear, Stops(), hang_limit)
        watched.send(message)
        await asyncio.wait_for(gone.wait(), LIMIT)
        assert not watched.alive
        return told

    return asyncio.run(listen())


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
    told = told_of(lines, message, hang_limit)
    assert [each for each in told if each["type"] != "stopped"] == [{"type": "gone", "message": reason}]


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
        client.wait_for_line("the stage exited unexpectedly: a new one is stopping the robots; save to play again")
        wait_until_gone({dead: ended}, LIMIT)
        client.save("file:///dance.improv")
        client.wait_for_line("▶")
        assert urlopen(page).status == 200, "the page that is open is served on"
        (new,) = ours(SIMULATOR).keys() - others
    wait_until_gone(ours(SIMULATOR), LIMIT)
    assert new != dead
