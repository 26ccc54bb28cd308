"""Detects that a stage's parent has fallen silent. It never reads a clock.

Only the code that reads the parent's own messages notes them here, so nothing that comes from ROS 2, a page, or a
sensor can make a silent parent seem alive.
"""

from __future__ import annotations

import math

from improv_core.protocol.limits import LOADING_LIMIT, SILENCE_LIMIT

DOUBT = 0.1
"""Seconds that the reading threads get to find messages that already wait, if this process was too busy to read them:
as long as between two pings."""


class Parent:
    """The latest signs of life of the parent, in monotonic seconds.

    The threads that read from the parent use `speaks` and `reading`, the stage's loop all others. Each field is written
    by only one side and replaced as a whole, so there is no lock.
    """

    def __init__(self) -> None:
        self.patience = SILENCE_LIMIT
        """Written by the loop: seconds without a ping after which the parent counts as hung."""
        self._silent_at = math.inf  # by a reader: the time at which it counts as hung; none before its first ping
        self._doubted = math.inf  # by the loop: the latest of these times that has passed
        self._since = math.inf  # by the loop: the time at which it noticed that
        self._given_up = math.inf  # by the loop: the latest of these times on which it has acted

    def speaks(self, now: float, *, pings: bool = False) -> None:
        """Note that one of its messages has been read. Its first ping promises more of them."""
        if pings or self._silent_at < math.inf:
            self._silent_at = now + self.patience

    def reading(self, now: float) -> None:
        """Note that a long message has arrived. The messages after it wait until that one has been read."""
        if self._silent_at < math.inf:
            self._silent_at = now + LOADING_LIMIT

    @property
    def deadline(self) -> float:
        """The time of the next call of `is_silent`."""
        at = self._silent_at
        if at == self._given_up:
            return math.inf
        return max(at, self._since + DOUBT) if at == self._doubted else at - DOUBT

    def is_silent(self, now: float) -> bool:
        """Return whether it has been silent for too long; true only once for each time.

        Two calls have to find it: a loop that was busy may ask before the reader has read the messages that arrived
        meanwhile.
        """
        at = self._silent_at
        if now < at - DOUBT or at == self._given_up:
            return False
        if at != self._doubted:
            self._doubted, self._since = at, now
        if now < max(at, self._since + DOUBT):
            return False
        self._given_up = at
        return True
