"""Checks whether an output keeps what every output promises: in real stages, which are stopped, halted, and killed."""

from __future__ import annotations

import asyncio
import math
import os
import signal
import socket
import struct
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from itertools import count

import click

from improv_core.commands.output_subjects import Subject
from improv_core.ipc.stage_process import Heard, RunningStage, Stage, StageError
from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.protocol.fields import PoseJson
from improv_core.safety.allowed import HostError, approve, withdraw
from improv_core.safety.stops import Stops
from improv_core.score.motion import STILL, Twist
from improv_core.score.score import Score
from improv_core.score.score_json import to_json
from improv_core.session.start import Options, start_stage

PATIENCE = 60.0
"""Seconds in which a robot has to begin to move, on a busy machine."""
QUIET = 0.7
"""Seconds for which a robot has to stand after it has stopped: something late could move it again."""
STALL = 0.7
"""Seconds for which a stage is halted and then continues: its commands are late then, and nobody has killed it yet."""
ABOVE = 1.02
"""The share of a limit that may be measured: motors count in whole units."""
_generations = count(1)
STANDING = 1e-3
"""The speed below which a simulated robot stands, in rad/s."""
SOON = 0.01
"""Seconds: two poses of a simulated robot are hardly nearer."""


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the table: a check, whether it has `passed` (None: it was not tried), and what was `found`."""

    check: str
    passed: bool | None
    found: str


async def checks(subject: Subject, limit: float) -> AsyncIterator[Row]:
    """Yield a row for each check. A robot has to stand within `limit` seconds, or those after which it promises to."""
    async with AsyncExitStack() as stack:
        eyes = Eyes(subject)
        try:
            stack.enter_context(subject.watch(eyes.see))
        except OSError as error:
            eyes = Person(subject)
            yield Row("seen by", None, f"you: {error}")
        try:
            async for row in _checks(subject, eyes, limit):
                yield row
        except (NotMovingError, StageError, HostError) as error:
            yield Row("moves", False, str(error))


async def _checks(subject: Subject, eyes: Eyes, limit: float) -> AsyncIterator[Row]:
    async with _playing(subject, eyes) as stage:
        yield Row("moves", True, f"{eyes.took:.2f} s after its first score" if eyes.measures else "")
        yield await _within_limits(subject, eyes, stage)
        _load(stage, subject.slow)
        await eyes.moving()
        stage.send({"type": "stop"})
        yield await eyes.stands("stop", limit)
        _load(stage, subject.slow)
        await eyes.moving()
        closing = asyncio.create_task(stage.close())
        yield await eyes.stands("end of a session", limit)
        await closing
    ends: Mapping[str, Sequence[int]] = {
        "stage killed": [signal.SIGKILL],
        "stage halted": [signal.SIGSTOP],
        "late commands": [signal.SIGSTOP, signal.SIGCONT],
    }
    for name, signals in ends.items():
        if not subject.is_real:
            yield Row(name, None, "no real robot")
            continue
        async with _playing(subject, eyes) as stage:
            for number in signals:
                with suppress(ProcessLookupError):  # its standby has ended it
                    os.kill(stage.pid, number)
                await asyncio.sleep(STALL if len(signals) > 1 and number == signal.SIGSTOP else 0.0)
            yield await eyes.stands(name, limit)
    async for row in _unplugged(subject, eyes, limit):
        yield row


async def _within_limits(subject: Subject, eyes: Eyes, stage: Stage) -> Row:
    most = subject.profile.max_angular
    if not subject.fast or not most or not eyes.measures:
        return Row("within its limits", None, "nothing measures its speed" if most else "its profile has no limits")
    eyes.fastest = 0.0
    _load(stage, subject.fast)
    await eyes.until(True, PATIENCE, above=most / 2)
    await asyncio.sleep(QUIET)
    return Row("within its limits", most / 2 < eyes.fastest <= most * ABOVE, f"{eyes.fastest:.2f} of {most:.2f} rad/s")


async def _unplugged(subject: Subject, eyes: Eyes, limit: float) -> AsyncIterator[Row]:
    device = subject.device
    if not device or not device.address.startswith("tcp:"):
        why = "no cable" if not device else "not tried: pull its plug while it plays"
        yield Row("unplugged", None, why)
        return
    async with Cable(device.address) as cable, _playing(subject, eyes, subject.at(cable.address)):
        eyes.lost.clear()
        cable.cut()
        yield await eyes.stands("unplugged", limit)
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(eyes.lost.wait(), PATIENCE)
        yield Row("is named", eyes.lost.is_set() and subject.robot in eyes.line, eyes.line)
        await cable.plug()
        await eyes.moving()
        yield Row("plugged in again", True, f"moves after {eyes.took:.2f} s" if eyes.measures else "")


@asynccontextmanager
async def _playing(subject: Subject, eyes: Eyes, score: Score | None = None) -> AsyncIterator[Stage]:
    """Start a stage of its own, and wait until the robot moves."""
    options = Options("ros", host=subject.host, find_python=find_ros_python)
    stage = await start_stage("ros" if subject.is_real else "simulator", options, "check", eyes.hear, Stops())
    assert isinstance(stage, Stage)
    try:
        _load(stage, score or subject.slow)
        await eyes.moving()
        yield stage
    finally:
        await stage.close()


def _load(stage: Stage, score: Score) -> None:
    generation = next(_generations)
    stage.send({"type": "load", "generation": generation, "score": to_json(score), "when": "restart", "backend": ""})


class NotMovingError(Exception):
    """The robot doesn't move. The message is one line with the reason."""


class Eyes:
    """Sees the robot move, by what its subject's `watch` reports, and hears what a stage says of it."""

    measures = True

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.took = self.fastest = 0.0
        """The seconds that the latest wait took, and the highest turning speed that was seen."""
        self.line = ""
        """The latest line for people."""
        self.lost = asyncio.Event()
        """Set if the stage says that something is wrong with the robot."""
        self._loop = asyncio.get_running_loop()
        self._zero: float | None = None  # when a clock of the robot's own began
        self._at: float | None = None  # the latest time on it
        self._seen: asyncio.Queue[tuple[Twist, float]] = asyncio.Queue()
        self._pose: tuple[int, float, PoseJson] | None = None

    def see(self, twist: Twist, at: float | None = None) -> None:
        """Take a velocity at a time on a clock of the robot's own, if it has one, on any thread."""
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._take, twist, at)

    def _take(self, twist: Twist, at: float | None = None) -> None:
        self.fastest = max(self.fastest, abs(twist.yaw))
        if at is not None:
            self._zero = time.monotonic() - at if self._zero is None else self._zero
            self._at = self._zero + at
        self._seen.put_nowait((twist, self._now()))

    def _now(self) -> float:
        """Return the time of the robot: a simulated one may be slower than the real one, or stand still for a while."""
        return time.monotonic() if self._at is None else self._at

    def hear(self, stage: RunningStage, message: Heard, stops: int) -> None:
        """Take a message of the stage. Of a simulated robot, it has the poses."""
        match message["type"]:
            case "warning" | "error" | "gone":
                self.line = message["message"]
            case "fault" if not message["over"]:
                self.line = message["message"]
                self.lost.set()
            case "measured" if not self.subject.is_real:
                for each in message["robots"].values():
                    before, self._pose = self._pose, (message["generation"], each["performed"], each["pose"])
                    if before and before[0] == message["generation"]:
                        turned = math.remainder(each["pose"]["heading"] - before[2]["heading"], math.tau)
                        rate = turned / max(each["performed"] - before[1], SOON)  # after a stop, no time passes in it
                        self._take(Twist(yaw=rate) if abs(rate) > STANDING else STILL)

    async def until(self, moves: bool, limit: float, above: float = 0.0) -> bool:
        """Wait until the robot is seen to move, perhaps turning faster, or to stand. Returns whether it was in time."""
        while not self._seen.empty():
            self._seen.get_nowait()
        began, end = self._now(), time.monotonic() + (limit if self._at is None else PATIENCE)
        while (left := end - time.monotonic()) > 0:
            with suppress(asyncio.TimeoutError):
                twist, at = await asyncio.wait_for(self._seen.get(), left)
                self.took = at - began
                if self.took > limit:
                    break
                if (twist != STILL) == moves and abs(twist.yaw) >= above:
                    return True
        return False

    async def moving(self) -> None:
        """Wait until the robot moves. Raises NotMovingError."""
        if not await self.until(True, PATIENCE):
            raise NotMovingError(f"it doesn't move: {self.line or 'nothing says why'}")

    async def stands(self, check: str, limit: float) -> Row:
        """Wait until the robot stands, and then whether it keeps standing."""
        if not await self.until(False, limit + QUIET):
            return Row(check, False, "it keeps moving")
        took = self.took
        again = self.measures and await self.until(True, QUIET)
        found = f"after {took:.2f} s" if self.measures else ""
        return Row(check, not again and took <= limit, found + (", then it moves again" if again else ""))


class Person(Eyes):
    """Asks a person, if nothing else sees the robot."""

    measures = False

    async def until(self, moves: bool, limit: float, above: float = 0.0) -> bool:
        does = f"Does {self.subject.robot} {'move' if moves else 'stand'}?"
        return await asyncio.to_thread(click.confirm, does)


class Cable:
    """A TCP connection to a robot that can be cut: whoever connects to `address` reaches it."""

    def __init__(self, to: str) -> None:
        host, _, port = to.removeprefix("tcp:").rpartition(":")
        self._to = host, int(port)
        self._at = 0
        self._ends: list[asyncio.StreamWriter] = []

    @property
    def address(self) -> str:
        return f"tcp:127.0.0.1:{self._at}"

    async def __aenter__(self) -> Cable:
        await self.plug()
        approve(self.address)
        return self

    async def __aexit__(self, *_: object) -> None:
        withdraw(self.address)
        self.cut()

    async def plug(self) -> None:
        """Accept connections, at the same address as before."""
        self._server = await asyncio.start_server(self._join, "127.0.0.1", self._at)
        self._at = self._server.sockets[0].getsockname()[1]

    def cut(self) -> None:
        """Reset all connections, and refuse others."""
        self._server.close()
        for end in self._ends:
            with suppress(OSError):  # it has ended
                end.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            end.transport.abort()
        self._ends = []

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, to = await asyncio.open_connection(*self._to)
        self._ends += [writer, to]
        await asyncio.gather(_pass_on(reader, to), _pass_on(there, writer))


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while data := await reader.read(4096):
            writer.write(data)
    writer.close()
