"""Exchanges OSC messages with music and show programs: passes their requests to the parent, and sends them the beats,
words, and senses of the dance on time.

It is a process of its own, so that a flood of messages delays nothing else. The parent starts it as
`python …/improv_core/stage osc [show]`. Standard library only (python-osc imported lazily).
"""

from __future__ import annotations

import errno
import heapq
import itertools
import logging
import math
import os
import secrets
import select
import socket
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from improv_core.ipc.rate_limit import MAX_MESSAGES, Flood, Throttle
from improv_core.music import osc_in, osc_out, osc_wire
from improv_core.plain import message as in_plain_text
from improv_core.preview.forecast import Forecast, WordBegins
from improv_core.protocol.commands import PageRequest
from improv_core.protocol.helper_messages import FromOsc, OscExchange, PeerJson, ToOsc
from improv_core.protocol.json_lines import Lines, own_output
from improv_core.protocol.messages import Armed, Sensed, TransportMessage
from improv_core.safety.stage_stops import stop_stages
from improv_core.score.score_json import RowsRead, from_json

NICENESS = 5
"""The process's niceness. If all processors are busy, commands come first."""
MAX_AT_ONCE = 100
"""The most datagrams to read before anything else is done."""
AHEAD, LOOK_PERIOD = 2.0, 1.0
"""Seconds that a forecast reaches ahead, and seconds between two forecasts."""
PATIENCE = 2.0
"""Seconds for which a port may be taken before people get a line about it."""
SAID = 60.0
"""Seconds before people get another line of the same kind."""

Say = Callable[[FromOsc], None]


def main() -> int:
    """Obey the parent's messages on standard input until it ends. On failure, report the error."""
    lines: Lines[ToOsc] = Lines()
    say: Say = own_output()
    os.nice(NICENESS)
    logging.disable()  # python-osc logs messages that it can't read
    try:
        _exchange(lines, say)
    except Exception as error:  # whatever python-osc raises, or that it is missing
        say({"type": "warning", "message": in_plain_text(f"OSC fails: {type(error).__name__}: {error}")})
        return 1
    return 0


def _exchange(lines: Lines[ToOsc], say: Say) -> None:
    osc_wire.written([], 0.0)  # imports everything it needs
    desk = OscDesk(say, show=Path(sys.argv[1]) if sys.argv[1:] else None)
    say({"type": "alive"})
    while not lines.ended:
        wait = max(desk.due - time.monotonic(), 0.0)
        waited: list[int | socket.socket] = [0, *desk.sockets]
        select.select(waited, [], [], None if wait == math.inf else wait)
        for message in lines.read():
            desk.take(message)
        desk.hear()
        desk.advance(time.monotonic())


class OscDesk:
    """The state of this process, and its sockets. Stops go straight to the stages of the `show`, too."""

    def __init__(
        self,
        say: Say,
        clock: Callable[[], float] = time.monotonic,
        wall: Callable[[], float] = time.time,
        show: Path | None = None,
    ) -> None:
        self._show = show
        self._say = say
        self._clock = clock
        self._wall = wall
        self._known, self._rows = osc_in.Situation(), RowsRead()
        self._port: socket.socket | None = None
        self._wanted: PeerJson | None = None  # the address to listen on
        self._allowed_hosts: set[str] = set()  # the addresses of machines that count, besides this one
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._out.setblocking(False)
        self._peers: list[tuple[str, int]] = []
        self._time_tags = True
        self._voice, self._forecast, self._begins = osc_out.Voice(), Forecast(), list[WordBegins]()
        self._looks = math.inf  # when the next forecast is due
        self._timers: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = itertools.count()
        self._throttle = Throttle(self._ask, self._later)
        self._flood = Flood()
        self._reported: dict[str, float] = {}

    @property
    def sockets(self) -> list[socket.socket]:
        """The sockets on which messages may arrive."""
        return [self._port] if self._port else []

    @property
    def due(self) -> float:
        """The time at which `advance` is due, in monotonic seconds."""
        timer = self._timers[0][0] if self._timers else math.inf
        return min(timer, self._voice.next(self._begins), self._looks) if self._peers else timer

    def take(self, message: ToOsc) -> None:
        """Take a message of the parent."""
        if message["type"] == "exchange":
            self._open(message)
        elif message["type"] == "plays":
            score = from_json(message["score"], self._rows)
            self._known = self._known.playing(score)
            self._forecast.add_score(score, message["generation"])
        else:
            self._known = self._known.after(message)
            self._follow(message)

    def hear(self) -> None:
        """Read messages that have arrived, but too few to keep anything else waiting."""
        for _ in range(MAX_AT_ONCE if self._port else 0):
            assert self._port
            try:
                datagram, (host, _port) = self._port.recvfrom(osc_wire.MAX_BYTES + 1)
            except BlockingIOError:
                return
            self.read(datagram, host)

    def advance(self, now: float) -> None:
        """Do everything that is due."""
        while self._timers and self._timers[0][0] <= now:
            heapq.heappop(self._timers)[2]()
        if self._peers:
            self._voice, due = self._voice.due(self._begins, now)
            self._send(due)
            if now >= self._looks:
                self._look(now)

    def _follow(self, message: TransportMessage | Sensed | Armed) -> None:
        """Send what changed to the other programs, and make a new forecast."""
        if message["type"] == "armed":
            return
        now = self._clock()
        self._forecast.take(message)
        if message["type"] == "transport":
            self._voice, due = self._voice.after(message)
            now = message["monotonic"]  # from that moment on, or words that begin then would be late
        else:
            self._voice, due = self._voice.sensed(message, self._wall(), now)
        if self._peers:
            self._send(due)
            self._look(now)

    def _look(self, now: float) -> None:
        self._forecast.compute(now, AHEAD)
        self._begins = list(self._forecast.words())
        self._looks = now + LOOK_PERIOD if self._forecast.is_moving else math.inf

    def _send(self, due: Sequence[osc_out.OscDue]) -> None:
        """Send messages: all that are due at the same time in one bundle, or each by itself."""
        offset = self._wall() - self._clock()
        if self._time_tags:
            datagrams = [
                osc_wire.written([(each.address, each.arguments) for each in together], at + offset)
                for at, together in itertools.groupby(due, lambda each: each.at)
            ]
        else:
            datagrams = [osc_wire.plain(each.address, each.arguments) for each in due]
        for datagram in datagrams:
            for peer in self._peers:
                try:
                    self._out.sendto(datagram, peer)
                except OSError as error:
                    self._complain(f"OSC can't be sent to {peer[0]}:{peer[1]}: {error.strerror}", about=f"{peer}")

    def _open(self, exchange: OscExchange) -> None:
        for port in self.sockets:
            port.close()
        self._port, self._allowed_hosts, self._peers = None, set(), []
        self._time_tags = exchange["time_tags"]
        for peer in exchange["send"]:
            try:
                host = socket.gethostbyname(peer["host"])
                self._allowed_hosts.add(host)
                self._peers.append((host, peer["port"]))
            except OSError as error:
                self._complain(f"OSC can't be sent to {peer['host']}: {error.strerror}", about=peer["host"])
        self._wanted = exchange["listen"]
        if self._wanted:
            self._listen(self._wanted, until=self._clock() + PATIENCE)

    def _listen(self, at: PeerJson, until: float) -> None:
        """Listen on an address, or try again for a moment: the process before this one may only just have ended."""
        if at is not self._wanted:
            return
        port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        port.setblocking(False)
        try:
            port.bind((at["host"], at["port"]))
        except OSError as error:
            port.close()
            if error.errno == errno.EADDRINUSE and self._clock() < until:
                self._later(PATIENCE / 10, lambda: self._listen(at, until))
                return
            line = f"OSC can't listen on {at['host']}:{at['port']}: {error.strerror}"
            self._complain(f"{line}; change `listen` under [osc] in improv.toml, then save", about="listen")
        else:
            self._port = port

    def read(self, datagram: bytes, host: str) -> None:
        """Obey a datagram from this address."""
        now = self._clock()
        if not host.startswith("127.") and host not in self._allowed_hosts:
            line = f"an OSC message from {host} was ignored: only this machine and those in `send` under [osc] count"
            self._complain(line, about="stranger")
            return
        floods = self._floods(now)
        if floods and not any(each in datagram for each in osc_in.URGENT):
            return
        if len(datagram) > osc_wire.MAX_BYTES:
            self._complain(f"an OSC message longer than {osc_wire.MAX_BYTES:,} bytes was ignored", about="broken")
            return
        try:
            messages = osc_wire.read(datagram)
        except osc_wire.BrokenError:
            self._complain("something that is not an OSC message was ignored", about="broken")
            return
        wall = self._wall()
        for number, message in enumerate(messages):
            floods = self._floods(now) if number else floods
            if not floods or message.address in osc_in.STOPS:
                self._obey(message, now, now + message.due - wall)

    def _floods(self, now: float) -> bool:
        """Count a message. Returns whether too many have come."""
        floods = self._flood.counts(now)
        if floods:
            line = f"more than {MAX_MESSAGES} OSC messages came within a second: only stops count"
            self._complain(line, about="flood")
        return floods

    def _obey(self, message: osc_wire.OscMessage, now: float, due: float) -> None:
        """Pass on the request of a message, or hold it until it is `due`."""
        try:
            asked = osc_in.request(message.address, message.arguments, self._known)
        except osc_in.UnclearError as error:
            self._complain(f"an OSC message was ignored: {error}", about=message.address[:60])
            return
        if asked is None:
            return
        if due <= now or not osc_in.waits(asked) or len(self._timers) >= osc_in.MAX_HELD:
            self._throttle.take(asked)
        elif due > now + osc_in.AHEAD:
            line = f"an OSC message was due more than {osc_in.AHEAD:g} s later, and was obeyed at once: compare clocks"
            self._complain(line, about="clock")
            self._throttle.take(asked)
        else:
            self._later(due - now, lambda: self._throttle.take(asked))

    def _later(self, seconds: float, act: Callable[[], None]) -> None:
        heapq.heappush(self._timers, (self._clock() + seconds, next(self._numbers), act))

    def _ask(self, asked: PageRequest) -> None:
        if asked["type"] == "stop" and self._show:
            asked["direct"] = f"osc-{secrets.token_hex(8)}"
            stop_stages(self._show, asked, 0.0)
        self._say({"type": "request", "command": asked})

    def _complain(self, line: str, about: str) -> None:
        """Report a problem, unless a similar one or many others were reported recently."""
        now = self._clock()
        self._reported = {each: at for each, at in self._reported.items() if at > now - SAID}
        if about not in self._reported and len(self._reported) < 10:
            self._reported[about] = now
            self._say({"type": "warning", "message": line})


if __name__ == "__main__":
    sys.exit(main())
