"""When a standby counts as lost, and when robots have moved for too long without one. It never reads a clock."""

from __future__ import annotations

import math

ANSWER_LIMIT = 0.5
"""Seconds within which a standby answers a pulse; one that doesn't is replaced."""
START_LIMIT = 5.0
"""Seconds within which a new one has to say something; on a quiet machine it takes half a second."""
READY_LIMIT = 5.0
"""Seconds that robots may move without a standby that is ready: discovery alone took up to 3.3 s."""
STALL = 0.3
"""Seconds between two looks after which we ourselves stood still, which says nothing of the standby."""


class Relief:
    """What is known about the standby, and at which times, in seconds. `look` comes before anything is decided."""

    def __init__(self, now: float) -> None:
        self._looked = now
        self._lacking = math.inf  # since when robots move without a standby that is ready
        self._due = math.inf  # when the standby counts as lost, unless it says something before
        self.starts(now)

    def starts(self, now: float) -> None:
        """There is a new one."""
        self._due = now + START_LIMIT

    def asks(self, now: float) -> None:
        """It was sent a pulse. Only the first one that is not answered counts."""
        if self._due == math.inf:
            self._due = now + ANSWER_LIMIT

    def hears(self) -> None:
        """It has said something."""
        self._due = math.inf

    def look(self, now: float) -> None:
        """All that it has said until now has been heard."""
        if now > self._looked + STALL:
            self._due += now - self._looked
        self._looked = now

    def is_lost(self) -> bool:
        """Whether the standby has to be replaced."""
        return self._looked >= self._due

    def must_stop(self, moving: bool, ready: bool) -> bool:
        """Whether robots have to be stopped, given whether they move, and whether a standby is ready to stop them."""
        if not moving or ready:
            self._lacking = math.inf
            return False
        self._lacking = min(self._lacking, self._looked)
        if self._looked < self._lacking + READY_LIMIT:
            return False
        self._lacking = self._looked
        return True
