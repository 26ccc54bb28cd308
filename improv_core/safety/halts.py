"""Notices that this process did not run: it was halted, or the machine slept. So robots may have moved meanwhile, and
what arrives a moment later may have waited since before a stop.
"""

from __future__ import annotations

import math
import sys
import time

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
