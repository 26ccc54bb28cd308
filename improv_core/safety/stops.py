"""Obeys and counts stops and pauses as they arrive, ahead of everything that still waits. Standard library only."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from improv_core.protocol.commands import PageRequest, Pause, Stop, Watched, is_stop
from improv_core.protocol.messages import Pressed, ToStage
from improv_core.safety.suspend import NOTICED, asleep

KNOWN = 0.25
"""Seconds after which people count as knowing of a press of an emergency stop. A request that arrives earlier may have
waited since before the press, as all do that arrive when a suspended process continues."""
BEHIND = 0.1
"""Seconds after which a stop that has gone straight to stages shows that we were halted, and that what arrives now may
have waited since before it. So stages obey nothing until people count as knowing of it."""
HALTED = 0.3
"""Seconds without `runs`, while we have stages, after which we had been halted. Whatever arrives then may have waited
since before a stop that came a moment ago."""
MOST_DIRECT = 256
"""Stops that have gone straight to stages and are remembered, to count each of them once."""


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
        self._stages: dict[Receiver, bool] = {}  # true if the stage's robots are real
        self._tell: list[Callable[[], object]] = []
        self._asleep = asleep
        self._slept = asleep()
        self._count = 0
        self._expected: Stop | None = None  # the next stop, if that has gone straight to stages
        self._direct: deque[str] = deque(maxlen=MOST_DIRECT)  # the identities of such stops that have been counted
        self._settled: tuple[str, ...] = ()  # those that stages were sent with their identities
        self._unsettled: dict[str, Stop] = {}  # those that have yet to be repeated, by their identities
        self._ran: float | None = None  # the latest time at which we ran; None while nothing shows that
        self._continued = -math.inf  # the latest time at which we continued after we had been halted
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

    def add(self, stage: Receiver, *, real: bool = False) -> None:
        """Also stop this stage from now on."""
        with self._lock:
            self._stages[stage] = real

    def discard(self, stage: Receiver) -> None:
        with self._lock:
            self._stages.pop(stage, None)

    def stop(self, message: Stop | Pause | None = None) -> None:
        """Send all stages a stop, or a pause, at once. If some have real robots, only these report that they obeyed its
        mark. A stop with a mark has gone straight to stages, too."""
        now, again = time.monotonic(), None
        with self._lock:
            if message is None:
                message, self._expected = self._expected or Stop(type="stop"), None
            timed = message.copy()
            asked = timed.get("at")
            was_halted = asked is not None and (now - asked > BEHIND or self._was_halted(now))
            timed["at"] = now
            if timed["type"] == "stop" and (direct := timed.pop("direct", timed.get("mark"))):
                self._direct.append(direct)
                if was_halted:
                    again = Stop(type="stop", direct=direct)
                    if "by" in timed:
                        again["by"] = timed["by"]
                else:
                    self._settled = (*self._settled, direct)[-MOST_DIRECT:]
                    timed["direct"] = direct
            any_real = any(self._stages.values())
            unmarked = timed.copy()
            if unmarked["type"] == "stop":
                unmarked.pop("mark", None)
            for stage, real in self._stages.items():
                stage.send(timed if real == any_real else unmarked)
            self._note(stop=timed["type"] == "stop")
        if again:
            self._settle_later(again)

    def runs(self, now: float) -> None:
        """Note that this process runs, as it does ten times a second while it has stages."""
        with self._lock:
            if self._ran is not None and now > self._ran + HALTED:
                self._continued = now
            self._ran = now

    def rests(self) -> None:
        """Note that until further notice, nothing shows whether this process runs: a stage has ended."""
        with self._lock:
            self._ran = None

    def _was_halted(self, now: float) -> bool:
        """Return whether this process was halted until a moment ago. Hold the lock."""
        return now < self._continued + KNOWN or (self._ran is not None and now > self._ran + HALTED)

    def _settle_later(self, stop: Stop) -> None:
        """Repeat a stop once people count as knowing of it. Only then, stages obey what is asked for after it."""
        with self._lock:
            self._unsettled[stop["direct"]] = stop
        timer = threading.Timer(KNOWN, self._repeat, [stop])
        timer.daemon = True
        try:
            timer.start()
        except RuntimeError:  # there can't be more threads now
            self._repeat(stop)

    def _repeat(self, stop: Stop) -> None:
        """Repeat a stop, unless that has happened."""
        with self._lock:
            waited = self._unsettled.pop(stop["direct"], None)
        if waited:
            self.stop(waited)

    def on_stop(self, tell: Callable[[], object]) -> None:
        """Call this at each stop from now on, on its thread; not at a pause. It must not wait for anything."""
        self._tell.append(tell)

    def know(self, count: int) -> None:
        """Note that people know of so many presses of emergency stops. Requests from before are no longer sent."""
        with self._lock:
            if count > self.known:
                self.known = count
                self._note(stop=True)

    def expect(self, stop: Stop) -> None:
        """Note the stop that comes next: it has gone straight to stages, too."""
        with self._lock:
            self._expected = stop

    @property
    def expected_since(self) -> float | None:
        """The time at which somebody asked for the stop that comes next, if that has gone straight to stages; None if
        none has."""
        with self._lock:
            return self._expected.get("at") if self._expected else None

    def has_settled(self, direct: str) -> bool:
        """Return whether stages have been sent this stop, so that they may obey what was asked for after it. Callable
        also while messages are sent."""
        return direct in self._settled

    def arrive(self, request: PageRequest | Watched) -> int:
        """Note a request from a page, and obey it if it is a stop or a pause. Returns the count that it carries.

        Each stage reports a stop that has come straight to it. Only the first report counts. What an automation asks
        for after its own stop can't have waited since before it.
        """
        if is_stop(request):
            if not self._is_known(request):
                self.stop(request)
        elif by := request.get("by"):
            with self._lock:
                its_own = [each for each in self._unsettled.values() if each.get("by") == by]
            for stop in its_own:
                self._repeat(stop)
        return self.count

    def _is_known(self, request: Stop | Pause) -> bool:
        if request["type"] != "stop" or "direct" not in request:
            return False
        with self._lock:
            return request["direct"] in self._direct

    def send(self, message: ToStage, stage: Receiver, asked: int) -> bool:
        """Send a message that makes robots move, unless a stop has come since the count was `asked`. Returns whether it
        was sent."""
        with self._lock:
            if self._counted() != asked:
                return False
            if message["type"] == "load":
                message["asleep"] = self._slept
            stage.send(message)
            return True

    def _counted(self) -> int:
        """Return the count, after checking whether the machine has slept."""
        slept = self._asleep()
        if slept > self._slept + NOTICED:
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
