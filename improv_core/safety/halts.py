"""Notices that this process was halted, so that what arrives a moment later may have waited since before a stop.

Callers pass the time in, in monotonic seconds.
"""

from __future__ import annotations

import math

KNOWN = 0.25
"""Seconds after which people count as knowing of a stop, or of a press of an emergency stop. A request that arrives
earlier may have waited since before it, as all do that arrive when a suspended process continues."""
BEHIND = 0.1
"""Seconds after which a stop that has gone straight to stages shows that we were halted, and that what arrives now may
have waited since before it. So stages obey nothing until people count as knowing of it."""
HALTED = 0.3
"""Seconds without `runs`, while we have stages, after which we had been halted. Whatever arrives then may have waited
since before a stop that came a moment ago."""


class Halts:
    """The times at which this process ran. Any thread may call it: it notes one time at once."""

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
