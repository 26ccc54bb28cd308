"""The one line of a stage's parent when the stage hangs, fails, or ends, without ROS."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import time
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
SIMULATOR = "stage\0--sink\0simulator"
"""A part of the command of its process."""
HANG = 0.4
"""Seconds without an answer after which a stage is killed here."""
READY = 'print(json.dumps({"type": "ready", "protocol": 2, "sink": "fake", "real": True}), flush=True)'
CHANNEL = "channel = open(int(os.environ['IMPROV_STOP_PIPE']), 'rb', buffering=0)"
PONG = 'print(json.dumps({**message, "type": "pong"}), flush=True)'


def moving(*lines: str) -> str:
    """Return a stage that reports that it moves robots, and then runs these lines."""
    moves = f"print(json.dumps({at('playing', 1)}), flush=True)"
    return "\n".join(["import json, os, sys, time", CHANNEL, READY, moves, *lines])


def stage(*lines: str) -> str:
    """Return a stage that runs these lines for each message, which is called `message` in them."""
    return moving("while lines := channel.readline():", " message = json.loads(lines)", *lines)


def told_of(code: str, *messages: ToStage, hang_limit: float = HANG) -> tuple[list[Heard], float]:
    """Return the messages of a stage that runs this code, from when it moves robots until it has ended, and the seconds
    between."""

    async def listen() -> tuple[list[Heard], float]:
        told: list[Heard] = []
        gone = asyncio.Event()

        def hear(_: Stage, message: Heard, stops: int) -> None:
            if message["type"] != "transport":
                told.append(message)
            if message["type"] == "gone":
                gone.set()

        watched = await Stage.start([sys.executable, "-c", code], os.environ, hear, Stops(), hang_limit)
        began = time.monotonic()
        for message in messages:
            watched.send(message)
        await asyncio.wait_for(gone.wait(), LIMIT)
        assert not watched.alive
        return told, time.monotonic() - began

    return asyncio.run(listen())


@pytest.mark.parametrize(
    "hang", ["import subprocess; subprocess.run(['sleep', '60'])", "os.kill(os.getpid(), 19)"], ids=["child", "SIGSTOP"]
)
def test_a_stage_that_does_not_answer_is_killed_with_all_that_it_started(hang: str) -> None:
    told, _ = told_of(stage(f" {hang}"))
    assert told == [{"type": "gone", "message": f"the stage did not answer for {HANG} s"}]


def test_a_librarys_output_is_not_a_message() -> None:
    lines = "5", "null", "[]", "{}", "{", '{"type": "pong"}'
    code = stage(f" print(*{lines}, sep=chr(10), flush=True)", " sys.exit(0)")
    told, _ = told_of(code, {"type": "stop"}, hang_limit=LIMIT)
    assert told == [{"type": "gone", "message": "the stage exited unexpectedly"}]


def test_a_stage_may_take_long_to_get_ready_for_a_score_but_not_after_that() -> None:
    """It takes longer to answer than it may, then answers once, then never again."""
    code = stage(
        " sys.stdin.readline()",  # the score
        f" time.sleep({HANG * 2})",
        f" message = json.loads(sys.stdin.readline()); {PONG}",
        " time.sleep(60)",
    )
    told, seconds = told_of(code, {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "fake"})
    assert told == [{"type": "gone", "message": f"the stage did not answer for {HANG} s"}]
    assert seconds > HANG * 2


def test_a_failed_stage_may_take_long_to_end_and_its_last_line_is_the_reason() -> None:
    last = '{"type": "stopped", "message": "no such topic"}'
    told, _ = told_of(moving(f"print('{last}', flush=True); time.sleep(1.8); sys.exit(1)"), hang_limit=1.5)
    assert [message["type"] for message in told] == ["stopped", "gone"]
    assert told[-1] == {"type": "gone", "message": "the stage failed: no such topic"}


def test_an_idle_stage_hears_nothing_until_it_is_needed_and_then_a_ping_first() -> None:
    code = "\n".join(
        [
            "import json, os, select, sys",
            CHANNEL,
            READY,
            "while select.select([channel], [], [], 0.7)[0]:",
            f" message = json.loads(channel.readline()); {PONG}",
            'print(json.dumps({"type": "warning", "message": "silence"}), flush=True)',
            "json.loads(sys.stdin.readline())",
            "kind = json.loads(channel.readline())['type'] if select.select([channel], [], [], 0)[0] else 'nothing'",
            'print(json.dumps({"type": "warning", "message": kind}), flush=True)',
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
            watched.send({"type": "resume"})
        await watched.close()
        return lines

    assert asyncio.run(listen()) == ["silence", "ping"]


class WithProcesses(Client):
    """Its stages are processes, as they are for people."""

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
