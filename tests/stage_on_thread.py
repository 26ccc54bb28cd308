"""The simulator's stage on a thread of the test's own process, where starting it costs nothing.

It is a whole stage except for its process: its messages in both directions pass through JSON, too. Stops come with
everything else, as on Windows. Only a process can show a stage that hangs or dies (tests/stage).
"""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import cast

import pytest

from improv_core.ipc.arrivals import Arrival, End, UrgentQueue
from improv_core.ipc.stage_process import Heard, HearStage, RunningStage, Stage, StageError
from improv_core.page.__main__ import TOKEN, open_simulated, options_in
from improv_core.plain import one_line
from improv_core.protocol.decoding import dumps, read_as
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.protocol.page_messages import ForPages
from improv_core.safety.heartbeat import Parent
from improv_core.safety.stops import Stops
from improv_core.score.score_json import RowsRead
from improv_core.session.start import Options, start_stage
from improv_core.session.state import Output
from improv_core.stage.loop import OpenedOutput, run
from improv_core.stage.process import SystemClock, report_sent
from improv_core.stage.stdio import arrival

USED = "improv_core.session.start.Stage"
"""The name that `StageOnThread` replaces."""
NAME = "stage of a test"


def running() -> set[threading.Thread]:
    """Return the stages that have not ended."""
    return {thread for thread in threading.enumerate() if thread.name == NAME}


async def start_on_thread(
    sink: Output, options: Options, token: str, hear: HearStage, stops: Stops
) -> RunningStage | None:
    """Like `start_stage`, for the simulator."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(USED, StageOnThread)
        return await start_stage(sink, options, token, hear, stops)


class StageOnThread:
    """A stage as a playback uses it; `start` is that of `Stage`."""

    def __init__(self, arguments: Sequence[str], token: str, hear: HearStage, stops: Stops) -> None:
        self._hear = hear
        self._stops = stops
        self._loop = asyncio.get_running_loop()
        self._inbox: UrgentQueue[Arrival] = UrgentQueue()
        self._read = RowsRead()
        self._closing = False
        options = options_in(arguments)
        opened, self.ready, self._viewer = open_simulated(options, self._tell, token)
        if options.report_sent:
            report_sent(opened.sink, self._tell)
        self._thread = threading.Thread(target=self._play, args=(opened,), name=NAME, daemon=True)
        self._thread.start()

    @classmethod
    async def start(
        cls, command: Sequence[str], env: Mapping[str, str], hear: HearStage, stops: Stops
    ) -> StageOnThread | Stage:
        _, _, *arguments = command
        if "ros" in arguments:
            return await Stage.start(command, env, hear, stops)
        try:
            return cls(arguments, env[TOKEN], hear, stops)
        except OSError as error:
            raise StageError(one_line(error)) from None

    @property
    def alive(self) -> bool:
        return self._thread.is_alive() and not self._closing

    def moving(self, robots: Iterable[str]) -> list[str]:
        """Return nothing: it has no real robots."""
        return []

    def send(self, message: ToStage) -> None:
        said = arrival(dumps(message), self._read)
        if isinstance(said, dict) and said["type"] == "page":
            self._viewer.publish(cast(ForPages, said["message"]))
        else:
            self._inbox.put(said)

    async def close(self) -> None:
        self._closing = True
        self._inbox.put(End())
        await asyncio.to_thread(self._thread.join)

    def _play(self, opened: OpenedOutput) -> None:
        run(opened, self._inbox, SystemClock(), Parent())
        self._viewer.close()
        self._soon({"type": "gone", "message": "the stage exited unexpectedly"}, 0)

    def _tell(self, message: FromStage) -> None:
        asked = self._stops.arrive(message["command"]) if message["type"] == "request" else 0
        self._soon(read_as(json.dumps(message).encode(), FromStage), asked)

    def _soon(self, message: Heard, asked: int) -> None:
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._told, message, asked)

    def _told(self, message: Heard, asked: int) -> None:
        if not (self._closing and message["type"] == "gone"):
            self._hear(self, message, asked)
