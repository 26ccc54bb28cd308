"""Obeys and counts stops and pauses as they arrive, ahead of everything that still waits (`Stops`), and decides which
requests they make void in a stage, or which wait for one that they have overtaken (`StopFence`). Standard library
only.

While this process did not run, because it was halted or the machine slept (`Halts`, `asleep`), robots may have moved,
and what arrives a moment later may have waited since before a stop.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from improv_core.protocol.commands import VOIDED_BY_STOP, PageOpened, PageRequest, Pause, Stop, is_stop

if TYPE_CHECKING:
    from improv_core.protocol.messages import Pressed, ToStage

MAX_DIRECT = 256
"""Stops that have gone straight to stages and are remembered, to count and obey each of them once."""
NEVER = -1
"""The count of requests that are older than a stop: they move nothing."""
KNOWN = 0.25
"""Seconds after which people count as knowing of a stop, or of a press of an emergency stop. A request that arrives
earlier may have waited since before it, as all do that arrive when a suspended process continues."""
BEHIND = 0.1
"""Seconds after which a stop that has gone straight to stages shows that we were halted, and that what arrives now may
have waited since before it. So stages obey nothing until people count as knowing of it."""
HALTED = 0.3
"""Seconds without `runs`, while we have stages, after which we had been halted. Whatever arrives then may have waited
since before a stop that came a moment ago."""
SLEPT = 0.1
"""Seconds that count as sleep. A caller that compares two readings of `asleep` has to allow for their errors."""
_EXACT = 0.01
"""Seconds that may pass while the clocks are read: the largest error."""
_TRIES = 10


def asleep() -> float:
    """Return the seconds for which the machine has slept since it was started, while its monotonic clock stood still;
    always 0 on systems that don't report it, which are all but Linux."""
    if sys.platform != "linux":
        return 0.0
    for _ in range(_TRIES):
        before, with_sleep = time.monotonic(), time.clock_gettime(time.CLOCK_BOOTTIME)
        if time.monotonic() < before + _EXACT:  # otherwise, other processes ran in between
            break
    return with_sleep - before


class Halts:
    """The times at which this process ran, which callers pass in, in monotonic seconds. Any thread may call it: it
    notes one time at once."""

    def __init__(self) -> None:
        self._ran: float | None = None  # the latest time at which we ran; None while nothing shows that
        self._continued = -math.inf  # the latest time at which we continued after we had been halted

    def runs(self, now: float) -> None:
        """Note that this process runs, as it does ten times a second while it has stages."""
        if self._ran is not None and now > self._ran + HALTED:
            self._continued = now
        self._ran = now

    def rests(self) -> None:
        """Note that until further notice, nothing shows whether this process runs: a stage has ended."""
        self._ran = None

    def has_waited(self, asked: float, now: float) -> bool:
        """Return whether what arrives now, together with a stop that somebody `asked` for, may be older than it."""
        ran = self._ran
        was_halted = now < self._continued + KNOWN or (ran is not None and now > ran + HALTED)
        return was_halted or now > asked + BEHIND


class Receiver(Protocol):
    """A stage, as far as stops need it."""

    def send(self, message: ToStage) -> None: ...


class Stops:
    """Counts stops and pauses, and sends each to all stages at once. Every method is thread-safe.

    A request to play carries the count from the moment it arrived. `send` drops it if a stop has come since then, so
    nothing that was requested before a stop plays after it. If the machine has slept, that counts as a stop: stages
    then stop their robots by themselves.

    Emergency stops stay here until they are released, whatever happens to the stage that heard them.
    """

    def __init__(self, asleep: Callable[[], float] = asleep) -> None:
        self._lock = threading.Lock()
        self._stages: dict[Receiver, None] = {}  # in the order in which they came
        self._tell: list[Callable[[], object]] = []
        self._asleep = asleep
        self._slept = asleep()
        self._count = 0
        self._latest = -math.inf  # the time of the latest stop or pause
        self._direct: dict[str, bool] = {}  # stops that have gone straight to stages, by identity: has it settled?
        self._unsettled: dict[str, Stop] = {}  # those that have yet to be repeated
        self.halts = Halts()
        self.stopped = 0
        """The number of these that were stops and not pauses."""
        self.unreachable = ""
        """The reason why `improv stop` can't reach this process, or "". If there is one, no real robot moves."""
        self.pressed: Pressed = {"type": "pressed", "topics": [], "count": 0}
        """The emergency stops that are on, by the latest report of a stage."""
        self.known = 0
        """The number of presses of emergency stops that people know of when they ask for something now."""

    @property
    def count(self) -> int:
        """The number of stops and pauses until now."""
        with self._lock:
            return self._counted()

    def add(self, stage: Receiver) -> None:
        """Also stop this stage from now on."""
        with self._lock:
            self._stages[stage] = None

    def discard(self, stage: Receiver) -> None:
        with self._lock:
            self._stages.pop(stage, None)

    def stop(self, message: Stop | Pause | None = None) -> None:
        """Send all stages a stop, or a pause, at once. One with an identity has gone straight to stages, too."""
        now, again = time.monotonic(), None
        with self._lock:
            timed = message.copy() if message else Stop(type="stop")
            asked, timed["at"] = timed.get("at"), now
            self._latest = max(min(now if asked is None else asked, now), self._latest)
            if timed["type"] == "stop" and (direct := timed.pop("direct", "")):
                if asked is None or not self.halts.has_waited(asked, now):
                    timed["direct"] = direct
                else:
                    again = self._unsettled[direct] = Stop(type="stop", direct=direct)
                    if "by" in timed:
                        again["by"] = timed["by"]
                self._direct[direct] = again is None
                if len(self._direct) > MAX_DIRECT:
                    del self._direct[next(iter(self._direct))]
            for stage in self._stages:
                stage.send(timed)
            self._note(stop=timed["type"] == "stop")
        if again:
            self._repeat_later(again)

    def _repeat_later(self, stop: Stop) -> None:
        """Repeat a stop once people count as knowing of it. Only then, stages obey what is asked for after it."""
        timer = threading.Timer(KNOWN, self._repeat, [stop])
        timer.daemon = True
        try:
            timer.start()
        except RuntimeError:  # there can't be more threads now
            self._repeat(stop)

    def _repeat(self, stop: Stop) -> None:
        with self._lock:
            waited = self._unsettled.pop(stop["direct"], None)
        if waited:
            self.stop(waited)

    def on_stop(self, tell: Callable[[], object]) -> None:
        """Call this at each stop from now on, on its thread; not at a pause. It must not wait for anything."""
        self._tell.append(tell)

    def know(self, count: int) -> None:
        """Note that people know of this many presses of emergency stops. Requests from before are no longer sent."""
        with self._lock:
            if count > self.known:
                self.known = count
                self._note(stop=True)

    def has_settled(self, direct: str) -> bool:
        """Return whether stages have been sent this stop, so that they may obey what was asked for after it. Callable
        also while messages are sent."""
        return self._direct.get(direct, False)

    def arrive(self, request: PageRequest | PageOpened) -> int:
        """Note a request from a page, and obey it if it is a stop or a pause. Returns the count that it carries. A stop
        that came after it may have arrived before it, by way of a stage.

        Each stage reports a stop that has come straight to it. Only the first report counts. What an automation asks
        for after its own stop can't have waited since before it.
        """
        if request["type"] == "page_opened":
            return self.count
        if is_stop(request):
            if not (request["type"] == "stop" and request.get("direct") in self._direct):
                self.stop(request)
        elif request.get("at", math.inf) < self._latest:
            return NEVER
        elif by := request.get("by"):
            with self._lock:
                its_own = [each for each in self._unsettled.values() if each.get("by") == by]
            for stop in its_own:
                self._repeat(stop)
        return self.count

    def send(self, message: ToStage, stage: Receiver, asked: int) -> bool:
        """Send a message that makes robots move, unless a stop has come since the count was `asked`, or one that went
        straight to stages has yet to follow here: until then, they obey nothing. Returns whether it was sent."""
        return self.send_all([(stage, message)], asked)

    def send_all(self, messages: Iterable[tuple[Receiver, ToStage]], asked: int) -> bool:
        """Send stages messages that make robots move, all or none of them, as `send` does."""
        with self._lock:
            if self._counted() != asked or self._unsettled:
                return False
            for stage, message in messages:
                if message["type"] == "load":
                    message["asleep"] = self._slept
                stage.send(message)
            return True

    def _counted(self) -> int:
        """Return the count, after checking whether the machine has slept."""
        slept = self._asleep()
        if slept > self._slept + SLEPT:
            self._slept = slept
            self._note(stop=True)
        self._slept = max(slept, self._slept)
        return self._count

    def _note(self, *, stop: bool) -> None:
        """Count a stop or a pause, and make the calls for a stop."""
        self._count = self._counted() + 1
        self.stopped += stop
        for tell in self._tell if stop else ():
            tell()


@dataclass(frozen=True, slots=True)
class StopFence:
    """The messages that have come on the channel of stops, where stops, pauses, and pings share one numbering.

    Each message on standard input names the latest of these numbers that was sent before it.
    """

    heard: int = 0
    """The highest number so far."""
    void: int = 0
    """A request is void if the latest number before it is less than this."""
    direct: frozenset[str] = frozenset()
    """The stops that have come straight here, and that the parent has yet to send. Until it has sent each, it may not
    have known of it, so all of its requests are void, whatever their numbers."""
    known: tuple[str, ...] = ()
    """The latest stops of that kind that the parent has sent."""

    def hear(self, kind: str, number: int) -> StopFence:
        """Return the fence after another message has come."""
        heard = max(self.heard, number)
        return replace(self, heard=heard, void=self.void if kind == "ping" else max(self.void, number))

    def hear_direct(self, stop: str) -> StopFence:
        """Return the fence after a stop has come straight here, unless so many wait already that it stays closed."""
        waits = stop not in self.known and len(self.direct) < MAX_DIRECT
        return replace(self, direct=self.direct | {stop}) if waits else self

    def has(self, stop: str) -> bool:
        """Return whether this stop has come straight here, or from the parent."""
        return stop in self.direct or stop in self.known

    def settle(self, stop: str) -> StopFence:
        """Return the fence after the parent has sent this stop, too: what it sends from now on was requested later."""
        return replace(self, direct=self.direct - {stop}, known=(*self.known, stop)[-MAX_DIRECT:])

    def lose(self) -> StopFence:
        """Return the fence after too long a silence has stopped robots: no request until now may move them."""
        return replace(self, void=self.heard + 1) if self.heard else self

    def voids(self, kind: str, after: int | None) -> bool:
        """Return whether a request sent after this number must not be obeyed. `after` is None if nobody counts."""
        return kind in VOIDED_BY_STOP and (bool(self.direct) or (after is not None and after < self.void))

    def awaits(self, kind: str, after: int | None) -> bool:
        """Return whether a request was sent after a message that has yet to come here, by the other pipe. That may be a
        stop, which must not stop what people asked for after it, or the first ping of a parent that had hung."""
        return kind in VOIDED_BY_STOP and after is not None and after > self.heard
