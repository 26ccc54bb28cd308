"""The messages on each of a stage process's two channels, by a process that writes down its input."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from pathlib import Path
from typing import Any

import pytest

from improv_core.ipc.stage_process import Heard, Stage
from improv_core.protocol.messages import ToStage
from improv_core.safety.stage_watchdog import Watch
from improv_core.safety.stops import Stops
from tests.ipc.test_watchdog import CHANNEL, LIMIT, READY


def received(*messages: ToStage) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return the messages from standard input, and those that had come on the channel of stops by the end of that."""
    waiting = sum(message["type"] not in ("stop", "pause") for message in messages)
    code = "\n".join(
        [
            "import json, os, select, sys",
            CHANNEL,
            READY,
            f"lines = [sys.stdin.readline() for _ in range({waiting})]",
            "first = []",
            "while select.select([channel], [], [], 0)[0]:",
            " first.append(channel.readline().decode())",
            'print(json.dumps({"type": "warning", "message": json.dumps([lines, first])}), flush=True)',
            "sys.stdin.read()",
        ]
    )

    async def listen() -> str:
        told: asyncio.Queue[Heard] = asyncio.Queue()
        stage = await Stage.start(
            [sys.executable, "-c", code], os.environ, lambda _, message, stops: told.put_nowait(message), Stops()
        )
        for message in messages:
            stage.send(message)
        said = await asyncio.wait_for(told.get(), LIMIT)
        await stage.close()
        return str(said.get("message"))

    lines, first = json.loads(asyncio.run(listen()))
    return _brief(lines), _brief(first)


def _brief(lines: list[str]) -> list[dict[str, Any]]:
    messages = map(json.loads, lines)
    return [{key: each[key] for key in ("type", "after", "number") if key in each} for each in messages]


def test_a_ping_precedes_messages_that_move_robots_and_each_is_numbered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Even if the pinging thread is held up: a stage without a ping would not notice that we hang."""
    monkeypatch.setattr(Watch, "may_ping", lambda watch, now: False)
    lines, first = received({"type": "stop"}, {"type": "seek", "beat": 2.0}, {"type": "resume"}, {"type": "cue"})
    assert first == [{"type": "stop", "number": 1}, {"type": "ping", "number": 2}]
    assert lines == [{"type": "seek", "after": 1}, {"type": "resume", "after": 2}, {"type": "cue", "after": 2}]


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
