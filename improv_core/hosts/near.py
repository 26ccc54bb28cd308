"""The near end of a link: for its parent, it is a stage like any other.

It reads the same lines on standard input and on the channel of stops, writes the same lines, and ends when they end
(docs/protocol.md). It answers pings itself, which shows that it lives. Frames from the far end show that the link does.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

from improv_core.hosts import texts
from improv_core.hosts.clock_queries import RESTING, Asking, answered, asked, estimated, lag, period, translation
from improv_core.hosts.connect import ConnectError, connect
from improv_core.hosts.frames import LONGEST_UP, UP, FrameError, Incoming, LinkFrame, Outgoing, number_in, time_in
from improv_core.hosts.time_translation import TimeTranslation, to_local, to_remote
from improv_core.ipc.child import Child
from improv_core.protocol.commands import Stop
from improv_core.protocol.decoding import ProtocolError, dumps, read_as
from improv_core.protocol.json_lines import own_output
from improv_core.protocol.limits import END_LIMIT, LONGEST_LINE, SILENCE_LIMIT, STOP_PIPE, STOP_SOCKETS
from improv_core.protocol.messages import DIRECT, FromStage, ToStage, TransportMessage, read_first
from improv_core.protocol.transport import may_move
from improv_core.safety.allowed import who
from improv_core.safety.stage_stops import OBEYED, StageSocket
from improv_core.safety.stop_server import Answer
from improv_core.safety.stops import asleep

BEYOND = 1.0
"""Seconds beyond the stage's own patience after which a silent link is given up while robots may move."""
QUIET = 1.0
"""Seconds of silence after which a line warns people, if robots may move for longer than that."""
HARMLESS_SILENCE = 10.0
"""Seconds of silence after which the link is given up while no robots may move."""
STALL = 0.5
"""Seconds by which we may be late ourselves. If we are later, the silence proves nothing about the link."""
MAX_DIRECT = 256
"""The most stops that may wait for the far end's confirmation. The oldest one is then never confirmed."""
LAST = END_LIMIT - 0.3
"""Seconds until we end although the far end has not: our parent would kill us a moment later."""
Say = Callable[[Mapping[str, Any]], None]


class NearEnd:
    """The near end's state of the far end, and the lines on their way to it. All threads share one lock."""

    def __init__(self, host: str, ssh: Child, say: Say) -> None:
        self._host = host
        self._ssh = ssh
        self._tell_parent = say
        self._changed = threading.Condition(threading.RLock())
        self._outgoing = Outgoing()
        now = time.monotonic()
        self._asking = Asking(now)
        self._translation: TimeTranslation | None = None
        self._seen: dict[str, Any] = {}  # poses of others' robots that the stage there has yet to get
        self._held: list[Mapping[str, Any]] = []  # messages of the stage from before its clock is known
        self._heard = self._looked = now
        self._linked = self._asked = 0.0  # the times of the latest `link` message and the latest question
        self._ready = False  # our parent expects that first
        self._moves = False
        self._patience = SILENCE_LIMIT
        self._quiet = False  # a line has reported the silence
        self._explained = False  # a line has reported why all ends
        self._ending = False  # our parent wants that
        self._gone = threading.Event()
        self._reached: StageSocket | None = None
        self._direct: dict[str, list[Answer]] = {}  # stops that have come straight here, and who waits for each

    @property
    def failed(self) -> bool:
        """True if the link ended although our parent didn't want that."""
        return not self._ending

    def run(self, said: bytes, show: Path | None = None) -> None:
        """Pass lines on until both ends have ended. The far end has sent `said` already. Stops that come straight to
        the socket of this stage of the `show` are passed on ahead of everything, and answered once the stage has obeyed
        them. Raises OSError."""
        if show:
            self._reached = StageSocket(show, self._host, self._stop)
        stops = os.environ.pop(STOP_PIPE, None)
        works: list[Callable[[], None]] = [self._write, self._read_input, lambda: self._read(said)]
        if stops:
            works.append(lambda: self._read_stops(int(stops)))
        for work in works:
            threading.Thread(target=work, daemon=True).start()
        while not self._gone.wait(self._look()):
            pass
        self._ssh.kill()
        if self._reached and self._ending:  # otherwise, robots there may still move
            self._reached.close()

    def _look(self) -> float:
        """Do what is due, and return the seconds until something else is."""
        with self._changed:
            now = time.monotonic()
            if now > self._looked + RESTING + STALL:
                self._heard = now
            self._looked = now
            wait = period(self._asking, now, moves=self._moves)
            if now >= self._asked + wait * 0.9:
                self._asked = now
                self._send_first(b"c%d\n" % (self._asking.number + 1))
            self._estimate(now)
            limit = self._patience + BEYOND if self._moves else HARMLESS_SILENCE
            quiet = self._moves and self._patience > QUIET and now > self._heard + QUIET
            if quiet and not self._quiet and self._ready:
                self._tell_parent({"type": "warning", "message": texts.quiet(QUIET, self._patience)})
            self._quiet = quiet
            if not self._ending and now > self._heard + limit:
                self._fail(texts.silent(limit))
                self._gone.set()
            return wait

    def _estimate(self, now: float) -> None:
        self._asking = estimated(self._asking, now)
        found = self._asking.found
        if not found or found.at < self._linked:
            return
        known = translation(self._asking, time.monotonic_ns(), time.time_ns(), asleep())
        if known and (not self._translation or found.at > self._linked):
            self._linked, self._translation = found.at, known
            held, self._held = self._held, []
            for message in held:
                self._pass_up(message)
            if self._ready:
                link = {"type": "link", "host": self._host, "offset": found.offset, "error": found.error}
                self._tell_parent({**link, "round_trip": found.round_trip, "lag": lag(self._asking)})
            self._changed.notify_all()

    def _read_input(self) -> None:
        with suppress(OSError), open(0, "rb", closefd=False) as stream:
            while (line := stream.readline(LONGEST_LINE)).endswith(b"\n"):
                self._pass_down(line[:-1])
            if len(line) == LONGEST_LINE:
                self._fail(texts.too_long(LONGEST_LINE))
        self._end()

    def _pass_down(self, line: bytes) -> None:
        try:
            message: ToStage = read_as(line, ToStage)
        except ProtocolError:  # the stage reports that
            self._put(line)
            return
        if message["type"] == "ping":
            self._tell_parent({"type": "pong", "number": message["number"]})
            self._put(line)
            return
        with self._changed:
            self._changed.wait_for(lambda: self._translation or self._gone.is_set())
            known = self._translation
        if known and message["type"] == "seen":
            with self._changed:
                self._seen |= to_remote(message, known)["robots"]
                self._changed.notify_all()
        elif known:
            if message["type"] == "load":
                patience: Any = message.get("patience")
                self._patience = float(patience) if type(patience) in (int, float) else SILENCE_LIMIT
                self._moves = True  # it may move from now on
            self._put(dumps(to_remote(message, known)), is_score=message["type"] == "load")

    def _read_stops(self, pipe: int) -> None:
        with suppress(OSError, ProtocolError), open(pipe, "rb", closefd=False) as stream:
            for line in stream:
                message, number = read_first(line)
                if message["type"] == "ping":
                    self._tell_parent({"type": "pong", "number": number})
                elif "at" in message and self._translation:
                    line = dumps(to_remote(message, self._translation)) + b"\n"
                self._send_first(b"s" + line)
        self._end()

    def _stop(self, stop: Stop, answer: Answer) -> None:
        """Pass on a stop that has come straight here, and answer it once the stage has obeyed."""
        with self._changed:
            if len(self._direct) >= MAX_DIRECT:
                del self._direct[next(iter(self._direct))]
            self._direct.setdefault(stop["direct"], []).append(answer)
        self._send_first(b"s" + json.dumps({**stop, "number": DIRECT}).encode() + b"\n")

    def _put(self, line: bytes, *, is_score: bool = False) -> None:
        with self._changed:
            self._outgoing.put(line, is_score=is_score)
            self._changed.notify_all()

    def _send_first(self, frame: bytes) -> None:
        with self._changed:
            self._outgoing.put_first(frame)
            self._changed.notify_all()

    def _end(self) -> None:
        """End all because our parent wants that: the far end ends, and stops its robots, once its input has ended."""
        with self._changed:
            self._ending = True
            self._outgoing.forget()
            self._changed.notify_all()
        if not self._gone.wait(LAST):
            self._gone.set()

    def _write(self) -> None:
        with suppress(OSError):  # ssh has ended
            while frame := self._next():
                self._ssh.write(frame)
        self._ssh.close_input()

    def _next(self) -> bytes | None:
        """Return the next frame; None after the last one."""
        with self._changed:
            while not (frame := self._outgoing.next()):
                if self._seen and self._outgoing.rests and not self._ending:  # so that no line waits behind poses
                    self._outgoing.put(dumps({"type": "seen", "robots": self._seen}))
                    self._seen = {}
                    continue
                if self._ending or self._gone.is_set():
                    return None
                self._changed.wait()
            if frame.startswith(b"c"):
                self._asking = asked(self._asking, number_in(frame[1:-1]), time.monotonic())
            return frame

    def _read(self, said: bytes) -> None:
        incoming = Incoming(UP, LONGEST_UP)
        try:
            while True:
                for frame in incoming.take(said):
                    self._hear(frame)
                said = self._ssh.read_some()
                self._heard = time.monotonic()
        except FrameError as error:
            self._fail(texts.strange(self._host, str(error)))
            self._ssh.kill()
        except EOFError:
            self._ssh.wait()
            self._fail(texts.of_ssh(self._host, [*self._ssh.errors]))
        self._gone.set()
        with self._changed:
            self._changed.notify_all()

    def _hear(self, frame: LinkFrame) -> None:
        """Handle a frame. Raises FrameError."""
        now = time.monotonic()
        if frame.letter == "c":
            with self._changed:
                self._asking = answered(self._asking, time_in(frame.rest), now)
        elif frame.letter == "a":
            with self._changed:
                self._outgoing.acknowledge(number_in(frame.rest))
                self._changed.notify_all()
        elif frame.letter == "e":
            self._fail(texts.of_far(self._host, frame.rest.decode(errors="replace")))
        elif frame.letter == "m":
            with suppress(ProtocolError):
                message: FromStage = read_as(frame.rest, FromStage)
                with self._changed:
                    self._pass_up(message)

    def _pass_up(self, message: Mapping[str, Any]) -> None:
        """Pass a stage's message to our parent, in times of this machine. Hold the lock."""
        if message["type"] == "pong":
            return
        if message["type"] == "transport":
            transport = cast(TransportMessage, message)
            self._moves = may_move(transport)
            if self._reached:
                self._reached.hear(transport)
        if message["type"] == "obeyed":
            for answer in self._direct.pop(message["direct"], ()):
                answer(OBEYED)
        if message["type"] in ("error", "stopped"):
            self._explained = self._explained or message["type"] == "error" or "message" in message
        if message["type"] == "error" and not self._translation:
            self._tell_parent(message)  # the stage has not started, so it has no times to translate
        elif self._translation is None:
            self._held.append(message)
        elif (crossed := to_local(message, self._translation)) is not None:
            self._ready = self._ready or message["type"] == "ready"
            self._tell_parent(crossed)

    def _fail(self, line: str) -> None:
        """End the link, and report the reason unless that has been done."""
        with self._changed:
            if not self._ending and not self._explained:
                self._explained = True
                self._tell_parent({"type": "error", "message": line})


def main() -> int:
    """Be a stage on another machine, for our parent. Returns exit code 2 if that fails."""
    options, stage = options_in(sys.argv[1:])
    say, speaking = own_output(), threading.Lock()
    sys.setswitchinterval(0.0005)

    def tell(message: Mapping[str, Any]) -> None:
        with speaking:
            say(message)

    domain = [] if options.domain is None else ["--domain", str(options.domain)]
    middleware = ["--rmw", options.rmw] if options.rmw else []
    arguments = ["--from", options.by, *domain, *middleware, "--", *stage]
    try:
        connection = connect(options.host, arguments, options.ssh_config)
    except ConnectError as error:
        tell({"type": "error", "message": str(error)})
        return 2
    near = NearEnd(options.host, connection.ssh, tell)
    show = os.environ.pop(STOP_SOCKETS, None)
    try:
        near.run(connection.said, Path(show) if show else None)
    except OSError as error:
        tell({"type": "error", "message": f"`improv stop` can't reach this: {error.strerror}"})
        return 2
    return 2 if near.failed else 0


def options_in(arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
    """Return our own options, with the host (`user@name:port`), and those of the stage."""
    host, *own = arguments or [""]  # not by argparse, which would take a host that begins with `-` for an option
    theirs = own.index("--ros-args") if "--ros-args" in own else len(own)
    parser = argparse.ArgumentParser(prog="improv near", allow_abbrev=False)
    parser.add_argument("--from", dest="by", default=who(os.getppid()), help="the name of the parent")
    parser.add_argument("--domain", type=int, help="ROS_DOMAIN_ID there")
    parser.add_argument("--rmw", help="RMW_IMPLEMENTATION there")
    parser.add_argument("--ssh-config", help="instead of the person's own configuration of ssh; for tests")
    parser.set_defaults(host=host)
    ours, stage = parser.parse_known_args(own[:theirs])
    return ours, [*stage, *own[theirs:]]
