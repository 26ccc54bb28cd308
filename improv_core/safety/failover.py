"""The rules by which a standby counts as lost, and by which robots have moved for too long without one. It never reads
a clock."""

from __future__ import annotations

import math

ANSWER_LIMIT = 0.5
"""Seconds within which a standby answers a pulse while robots move; otherwise it is replaced."""
START_LIMIT = 5.0
"""Seconds within which a new standby sends its first message, on a quiet machine after half a second; and within which
one answers while robots stand: until then it may be creating publishers, which takes long on a busy machine."""
READY_LIMIT = 5.0
"""Seconds that robots may move without a standby that is ready: discovery alone took up to 3.3 s."""
STALL = 0.3
"""Seconds between two calls of `note_time` after which this process itself must have stalled. That proves nothing about
the standby."""


class StandbyMonitor:
    """The facts about the standby, and their times in seconds. Call `note_time` before each decision."""

    def __init__(self, now: float) -> None:
        self._looked = now
        self._lacking = math.inf  # the time since which robots move without a standby that is ready
        self._due = math.inf  # the time at which the standby counts as lost, unless it sends something before
        self.note_start(now)

    def note_start(self, now: float) -> None:
        """Note that there is a new standby."""
        self._due, self._starts = now + START_LIMIT, True

    def note_pulse(self, now: float, moving: bool) -> None:
        """Note that the standby was sent a pulse, and whether robots move."""
        if not self._starts:
            self._due = min(self._due, now + (ANSWER_LIMIT if moving else START_LIMIT))

    def note_message(self) -> None:
        """Note that the standby has sent something."""
        self._due, self._starts = math.inf, False

    def note_time(self, now: float) -> None:
        """Note that everything that the standby has sent until now has been read."""
        if now > self._looked + STALL:
            self._due += now - self._looked
        self._looked = now

    def is_lost(self) -> bool:
        """Return whether the standby has to be replaced."""
        return self._looked >= self._due

    def must_stop(self, moving: bool, ready: bool) -> bool:
        """Return whether robots have to be stopped, from whether they move and whether a standby is ready to stop
        them."""
        if not moving or ready:
            self._lacking = math.inf
            return False
        self._lacking = min(self._lacking, self._looked)
        if self._looked < self._lacking + READY_LIMIT:
            return False
        self._lacking = self._looked
        return True
