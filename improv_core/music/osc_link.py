"""The parent's side of the process that speaks OSC (music/osc.py). Standard library only."""

from __future__ import annotations

from asyncio import Event, TimeoutError, get_running_loop, wait_for
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Literal, TypeAlias

from improv_core.ipc.child import Policy
from improv_core.ipc.helper import Helper
from improv_core.protocol.commands import PageRequest
from improv_core.protocol.helper_messages import FromOsc, PeerJson, ToOsc
from improv_core.protocol.limits import helper_command
from improv_core.protocol.messages import Armed, Sensed, TransportMessage
from improv_core.safety.stops import Stops
from improv_core.score.osc import Osc
from improv_core.score.score import Score
from improv_core.score.score_json import RowsWritten, to_json

Reach = Literal["nowhere", "here", "network"]
"""The range of OSC messages: none, this machine, or everything in improv.toml."""
POLICY = Policy(2.0)
READY_LIMIT = 2.0
"""Seconds that a play may wait for the process to start."""


HearOsc: TypeAlias = Callable[[FromOsc | None], None]
"""Gets the process's messages, on a thread; None once it has ended."""


class OscLink:
    """Has a process exchange OSC messages while the score that plays asks for that.

    `ask` gets each request and the count of stops at its arrival, and `say` gets lines for people; both are called on
    the event loop. The thread that reads obeys stops, as with those of pages; the process sends them straight to the
    stages of the `show`, too.
    """

    def __init__(
        self,
        reach: Reach,
        stops: Stops,
        ask: Callable[[PageRequest, int], None],
        say: Callable[[str], None],
        start: Callable[[HearOsc], Helper] | None = None,
        show: Path | None = None,
    ) -> None:
        self._reach = reach
        self._stops = stops
        self._ask = ask
        self._say = say
        self._start = start or partial(_start, show)
        self._process: Helper | None = None
        self._number = 0  # counts the processes
        self._ready: Event | None = None  # set once the process has started or ended
        self._osc: Osc | None = None
        self._refused: Osc | None = None  # the settings whose refusal was already reported
        self._written = RowsWritten()

    def expect(self, score: Score) -> None:
        """Start, keep, or end the process, so that it is ready when this score plays."""
        osc = score.osc if self._reach != "nowhere" else None
        if osc and osc.away and self._reach != "network":
            if osc != self._refused:
                self._refused = osc
                line = f"OSC is off: {osc.away} in improv.toml reaches other machines. Allow that with --osc-network"
                self._say(f"{line}, or the setting osc.network")
            osc = None
        if not osc or (self._process and not self._process.is_alive):
            self.close()
        if osc:
            self._exchange(osc)

    async def ready(self) -> None:
        """Wait briefly until the process is ready to report beat 0 to others."""
        if self._process and self._ready:
            with suppress(TimeoutError):
                await wait_for(self._ready.wait(), READY_LIMIT)

    def plays(self, score: Score, generation: int) -> None:
        """Pass on a score that was sent to the stage."""
        self.expect(score)
        if self._process:
            self._written = self._written.renewed()
            self._put({"type": "plays", "generation": generation, "score": to_json(score, self._written)})

    def tell(self, message: TransportMessage | Sensed | Armed) -> None:
        """Pass on a message of the stage that leads."""
        if self._process:
            self._put(message)

    def close(self) -> None:
        """End the process, without waiting."""
        if self._process:
            self._process.close()
        self._process = self._osc = None

    def _exchange(self, osc: Osc) -> None:
        if not self._process:
            loop, number = get_running_loop(), self._number + 1

            def hear(message: FromOsc | None) -> None:  # on a thread, which obeys a stop at once
                asked = self._stops.arrive(message["command"]) if message and message["type"] == "request" else 0
                with suppress(RuntimeError):  # the loop has been closed
                    loop.call_soon_threadsafe(self._receive, number, message, asked)

            self._ready = Event()
            self._number, self._process = number, self._start(hear)
            self._written = RowsWritten()
        if osc != self._osc:
            self._osc = osc
            listen = _json(osc.listen) if osc.listen else None
            send = [_json(peer) for peer in osc.send]
            self._put({"type": "exchange", "send": send, "listen": listen, "time_tags": osc.time_tags})

    def _put(self, message: ToOsc) -> None:
        assert self._process
        self._process.put(message)

    def _receive(self, number: int, message: FromOsc | None, asked: int) -> None:
        if number != self._number or not self._process:
            return
        if self._ready:
            self._ready.set()
        if message is None:
            self.close()
            self._say("the process that speaks OSC has ended: the next play starts another one")
        elif message["type"] == "alive":
            return
        elif message["type"] == "warning":
            self._say(message["message"])
        elif message["command"]["type"] != "page_opened":
            self._ask(message["command"], asked)


def _start(show: Path | None, hear: HearOsc) -> Helper:
    return Helper(
        helper_command("music.osc", *([str(show)] if show else [])), POLICY, FromOsc, hear, lambda why: hear(None)
    )


def _json(peer: tuple[str, int]) -> PeerJson:
    host, port = peer
    return {"host": host, "port": port}
