"""Whether a stage's parent still speaks. It never reads a clock.

Only what reads the parent's own messages notes them here, so nothing that comes from ROS 2, a page, or a sensor can
make a silent parent seem alive.
"""

from __future__ import annotations

import math

from improv_core.protocol.limits import LOADING_LIMIT, SILENCE_LIMIT

DOUBT = 0.1
"""Seconds that whoever reads gets to find what already waits, if we ourselves have been too busy to notice: as many as
there are between two pings."""


class Parent:
    """When the parent was last heard, in monotonic seconds.

    The threads that read from the parent use `speaks` and `reading`, the stage's loop all others. Each field is written
    by only one side and replaced as a whole, so there is no lock.
    """

    def __init__(self) -> None:
        self.patience = SILENCE_LIMIT
        """By the loop: seconds without a ping after which it counts as hung."""
        self._silent_at = math.inf  # by a reader: when it counts as hung unless it speaks; never before its first ping
        self._doubted = math.inf  # by the loop: which of these times has been passed
        self._since = math.inf  # by the loop: when it found that
        self._given_up = math.inf  # by the loop: for which of these times it has acted

    def speaks(self, now: float, *, pings: bool = False) -> None:
        """One of its messages has been read. Its first ping promises more of them."""
        if pings or self._silent_at < math.inf:
            self._silent_at = now + self.patience

    def reading(self, now: float) -> None:
        """A long message has arrived, and what comes after it waits until that has been read."""
        if self._silent_at < math.inf:
            self._silent_at = now + LOADING_LIMIT

    @property
    def deadline(self) -> float:
        """When to ask whether it is silent."""
        at = self._silent_at
        if at == self._given_up:
            return math.inf
        return max(at, self._since + DOUBT) if at == self._doubted else at - DOUBT

    def is_silent(self, now: float) -> bool:
        """Whether it has been silent for too long; once for each time.

        That has to be found twice: a loop that was busy may come here before what has arrived meanwhile was read.
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
