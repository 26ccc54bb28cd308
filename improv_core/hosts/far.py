"""The far end of a link: near the robots, it starts a stage, passes lines to it and from it, and ends with its link.

It sends nothing of its own to the stage. So a stage whose link is silent gets nothing on its channel of stops, and
stops its robots as it does if its parent hangs.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import queue
import select
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from improv_core.hosts.exclusive_use import TakenError, take
from improv_core.hosts.frames import DOWN, LONGEST_DOWN, FrameError, Incoming, LinkFrame, RemoteTimes, number_in
from improv_core.ipc.child import Child, Policy
from improv_core.outputs.ros.discovery import described, limited
from improv_core.outputs.ros.setup.interpreter import Interpreter, InterpreterError, find_ros_python
from improv_core.protocol.limits import END_LIMIT, FOLDER, STOP_PIPE
from improv_core.safety.heartbeat import LOOK_PERIOD, StageWatchdog
from improv_core.safety.stops import asleep

SILENCE_LIMIT = 20.0
"""Seconds of silence after which the link counts as dead: its near end always asks for the time."""
REST_PERIOD = 0.5
"""Seconds between two checks whether the stage hangs, and between two checks of the link, while the stage rests."""
MAX_WAITING = 1_000_000
"""The bytes from the stage that may wait for the link. Then the stage is not read until some have left."""
POLICY = Policy(END_LIMIT, leads=True, errors=subprocess.PIPE)
SHORT = 1_000
"""Only lines with fewer bytes are parsed: pings, pongs, and reports whether robots move are short."""


class EndedError(Exception):
    """The far end has to end: its link has, or another one takes over."""


class FarOutbox:
    """The output to the near end. Any thread may put something in; one takes it out."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._first: deque[bytes | tuple[int, int]] = deque()
        self._lines: deque[bytes] = deque()
        self._waiting = 0
        self._closed = False

    def put_first(self, frame: bytes | tuple[int, int]) -> None:
        """Send this before all lines of the stage: a frame, or the number of a question and the time of its arrival."""
        with self._changed:
            self._first.append(frame)
            self._changed.notify_all()

    def put(self, frame: bytes) -> None:
        """Send this after all others; wait until fewer wait."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting < MAX_WAITING or self._closed)
            self._lines.append(frame)
            self._waiting += len(frame)
            self._changed.notify_all()

    def close(self) -> None:
        """Release all threads that wait here, once the waiting output has been sent."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def write(self) -> None:
        """Write all output to standard output, until this is closed or nobody reads there."""
        with suppress(OSError):
            while data := self._next():
                while data:
                    data = data[os.write(1, data) :]

    def _next(self) -> bytes:
        with self._changed:
            self._changed.wait_for(lambda: self._first or self._lines or self._closed)
            if self._first:
                frame = self._first.popleft()
                return frame if isinstance(frame, bytes) else _remote_times(*frame)
            if not self._lines:
                return b""
            line = self._lines.popleft()
            self._waiting -= len(line)
            self._changed.notify_all()
            return line


def _remote_times(number: int, arrived: int) -> bytes:
    answered, wall = time.monotonic_ns(), time.time_ns()
    return RemoteTimes(number, arrived, answered, wall, round(asleep() * 1e9)).frame()


class FarEnd:
    """The stage, and the lines that are on their way to it and from it."""

    def __init__(self, outbox: FarOutbox) -> None:
        self._outbox = outbox
        self._input: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()  # of the stage
        self._stops_there, self._stops_here = os.pipe()
        os.set_blocking(self._stops_here, False)
        self._watch = StageWatchdog(time.monotonic())
        self._ready = False  # before that, the stage may take as long as its parent allows
        self._begun = b""  # of a line for the stage, as long as it is short
        self._child: Child | None = None
        self._ending = False
        self.over = threading.Event()
        """Set once the stage has ended, or can never start."""

    def play(self, start: Callable[[int], Child]) -> None:
        """Start the stage with its channel of stops, and pass lines on until it ends."""
        try:
            child = start(self._stops_there)
        except (StartError, OSError) as error:
            self.fail(str(error))
        else:
            self._child = child
            threading.Thread(target=self._write, args=(child,), daemon=True).start()
            self._read(child)
            code = child.wait()
            if not self._ending:
                killed = code is None or code < 0
                self.fail(f"stage {child.last_error or ('it was killed' if killed else 'it exited unexpectedly')}")
        finally:
            os.close(self._stops_there)
            self.over.set()

    def look(self, describe: Callable[[], Mapping[str, Any]]) -> None:
        """Send a description of this machine. The end of the input ends us."""
        self._outbox.put(b"i%b\n" % json.dumps(describe()).encode())
        os.close(self._stops_there)

    def fail(self, why: str) -> None:
        """Send the reason why the link ends: a word that the near end knows, and details."""
        self._outbox.put_first(b"e%b\n" % why.replace("\n", " ").encode())

    def obey(self, frame: LinkFrame) -> None:
        """Obey a frame. Raises FrameError."""
        if frame.letter == "c":
            self._outbox.put_first((number_in(frame.rest), time.monotonic_ns()))
        elif frame.letter == "s":
            self._note(frame.rest)
            with suppress(OSError):  # the stage has ended, or hangs and will be killed
                os.write(self._stops_here, frame.rest + b"\n")
        elif frame.letter == "l":
            self._watch.loading(None)
        else:
            ends = frame.letter == "M"
            if len(self._begun) < SHORT:
                self._begun += frame.rest
            if ends:
                self._note(self._begun, by_input=True)
                self._begun = b""
            self._input.put(frame.rest + (b"\n" if ends else b""))

    def end(self) -> None:
        """End the stage, which stops its robots, or kill it if it takes too long."""
        self._ending = True
        self._input.put(None)
        os.close(self._stops_here)
        if self._child and not self.over.wait(END_LIMIT):
            self._child.kill()
            self.over.wait(END_LIMIT)

    def _note(self, line: bytes, *, by_input: bool = False) -> None:
        """Note that a line reaches the stage, which has to answer pings: on its input, one is behind each score."""
        if (number := _number_of(line, b"ping")) is not None:
            self._watch.ping(number)
            if by_input:
                self._watch.loading(number)

    def _write(self, child: Child) -> None:
        with suppress(OSError):  # it has ended
            while data := self._input.get():
                child.write(data)
                self._outbox.put_first(b"a%d\n" % (len(data) + (not data.endswith(b"\n"))))
        child.close_input()

    def _read(self, child: Child) -> None:
        with suppress(EOFError):
            while True:
                rests = self._watch.rests(time.monotonic())
                for line in child.read(REST_PERIOD if rests else LOOK_PERIOD):
                    self.hear(line, time.monotonic())
                    self._outbox.put(b"m%b\n" % line)
                if limit := self.exceeded(time.monotonic()):
                    child.kill()
                    self.fail(f"hung {limit:g}")
                    return

    def hear(self, line: bytes, now: float) -> None:
        """Note what a line of the stage says about it."""
        if (number := _number_of(line, b"pong")) is not None:
            self._watch.pong(number, now)
        elif line.startswith(b'{"type": "transport"'):
            moves = b'"state": "playing"' in line
            self._watch.moving(moves, moves, now)
        elif line.startswith(b'{"type": "ready"'):
            self._ready = True
        elif line.startswith(b'{"type": "stopped"'):
            self._watch.stopped(now)

    def exceeded(self, now: float) -> float | None:
        """Return the limit that the stage has exceeded, in seconds; None if it responds, or if no ping has come through
        the link that it could answer."""
        return self._watch.look(now, real=True) if self._ready and self._watch.waits else None


def _number_of(line: bytes, kind: bytes) -> int | None:
    """Return the number of a ping or a pong; None for anything else."""
    if len(line) < SHORT and kind in line:
        with suppress(ValueError, RecursionError):
            message = json.loads(line)
            if isinstance(message, dict) and message.get("type") == kind.decode():
                number = message.get("number")
                return number if type(number) is int else None
    return None


class StartError(Exception):
    """No stage can be started. The message is a word that the near end knows, and details."""


def ros_here() -> Interpreter:
    """Return the Python here that has rclpy. Raises StartError."""
    try:
        found = find_ros_python(None)
    except InterpreterError as error:
        raise StartError(f"python {error}") from None
    if found is None:
        raise StartError("no-ros")
    return found


def described_here() -> Mapping[str, Any]:
    """Return a description of this machine, for `improv doctor`."""
    told: dict[str, Any] = {"python": platform.python_version(), "machine": platform.machine(), "ros": None}
    try:
        found = ros_here()
    except StartError as error:
        return {**told, "problem": str(error)}
    env = limited(found.env)
    told |= {"ros": f"{found.env.get('ROS_DISTRO') or 'ROS 2'} from {found.origin}", "ros_python": found.python}
    return {**told, "reach": described(env), "rmw": env.get("RMW_IMPLEMENTATION") or "the default"}


def main() -> int:
    """Be the far end until the link ends or the stage does."""
    options, stage = options_in(sys.argv[1:])
    outbox = FarOutbox()
    writer = threading.Thread(target=outbox.write, daemon=True)
    writer.start()
    outbox.put_first(b"h\n")
    if options.domain is not None:
        os.environ["ROS_DOMAIN_ID"] = str(options.domain)
    if options.rmw:
        os.environ["RMW_IMPLEMENTATION"] = options.rmw
    signal.signal(signal.SIGTERM, _end)
    if options.set_up:
        from improv_core.hosts.far_setup import set_up_here

        set_up_here(options.set_up, outbox.put)
        outbox.close()
        writer.join(1.0)
        return 0
    far = FarEnd(outbox)
    work = partial(far.look, described_here) if options.look else partial(far.play, partial(_start, options.by, stage))
    player = threading.Thread(target=work, daemon=True)
    player.start()
    try:
        listen(far)
    except (FrameError, EndedError) as error:
        far.fail(f"ended {error}")
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    far.end()
    player.join(END_LIMIT)
    outbox.close()
    writer.join(1.0)  # a link that takes no more output must not keep us
    return 0


def listen(far: FarEnd) -> None:
    """Obey the frames on standard input, until that or the stage ends. Raises FrameError, EndedError."""
    incoming = Incoming(DOWN, LONGEST_DOWN)
    heard = time.monotonic()
    while not far.over.is_set():
        readable, _, _ = select.select([0], [], [], REST_PERIOD)
        if readable:
            data = os.read(0, 65_536)
            if not data:
                return
            heard = time.monotonic()
            for frame in incoming.take(data):
                far.obey(frame)
        elif time.monotonic() > heard + SILENCE_LIMIT:
            raise EndedError("nothing came through the link")


def options_in(arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
    """Return our own options, and those of the stage."""
    parser = argparse.ArgumentParser(prog="improv far", allow_abbrev=False)
    parser.add_argument("--from", dest="by", default="somebody", help="the name of the parent")
    parser.add_argument("--domain", type=int, help="ROS_DOMAIN_ID")
    parser.add_argument("--rmw", help="RMW_IMPLEMENTATION")
    parser.add_argument("--look", action="store_true", help="say what holds here, and start nothing")
    parser.add_argument("--set-up", help="set up ROS 2 here, and prove it with this score")
    own = list(arguments)
    end = own.index("--") if "--" in own else len(own)
    return parser.parse_args(own[:end]), own[end + 1 :]


def _start(by: str, stage: Sequence[str], pipe: int) -> Child:
    try:
        take(Path(__file__).resolve().parents[3], by)
    except TakenError as error:
        raise StartError(f"taken {error}") from None
    found = ros_here()
    command = [found.python, str(FOLDER), "--sink", "ros", *stage]
    return Child(command, POLICY, {**found.env, STOP_PIPE: str(pipe)}, pass_fds=[pipe])


def _end(*_: object) -> None:
    raise EndedError("another link of the same Improv takes over")
