"""Notices that another process does not run: a stage (`StageWatchdog`), or its parent (`Parent`). Standard library
only; callers pass the time in.

Only the code that reads the parent's own messages notes them for `Parent`, so nothing that comes from ROS 2, a page, or
a sensor can make a silent parent seem alive.
"""

from __future__ import annotations

import math

from improv_core.protocol.limits import END_LIMIT, HANG_LIMIT, LOADING_LIMIT, SILENCE_LIMIT

PING_PERIOD = 0.1
"""Seconds between two pings. They show the stage that we are alive, and its answers show us that it is."""
LOOK_PERIOD = PING_PERIOD / 4
"""Seconds between two checks whether the stage hangs."""
HARMLESS_HANG_LIMIT = 3.0
"""Seconds without an answer after which a stage that moves no real robots counts as hung: it does no harm if late."""
REST = 1.0
"""Seconds after the last message until a stage that moves nothing and has answered is no longer pinged."""
PULSE_LIMIT = 3.0
"""Seconds our event loop may stall, for example on a huge document, before we count as hung ourselves."""


class StageWatchdog:
    """The pings and answers of one stage. Times are monotonic, in seconds.

    Several threads use it without a lock, because only one thread writes each field: the one that pings (`ping`), the
    one that writes scores (`loading`), the one that reads (`pong`, `moving`, `stopped`), or the event loop (`look`).
    Of several that are `writing`, any may come last.
    """

    def __init__(self, now: float) -> None:
        self._pinged = 0  # by the pinging thread: the number of the latest ping
        self._loads_end_with: int | None = 0  # by the writer: the ping after the latest score
        self._loaded = 0  # by the reader: the latest of these with an answer
        self._wrote = now  # the time of the latest message that is no ping
        self._plays = False  # by the reader: true while robots move
        self._moves = False  # by the reader: true while they do, or may do so by themselves
        self._moved = now  # by the reader: the time of the latest report about that
        self._answered = now  # by the reader
        self._pongs = 0  # by the reader: the highest number with an answer
        self._looked = now  # by the event loop
        self._forgiven = now  # by the event loop: the end of the latest time in which this process stalled

    def may_ping(self, now: float) -> bool:
        """Return whether to send a ping now. False while our event loop hangs, so that the stage notices."""
        return now - max(self._looked, self._wrote) <= PULSE_LIMIT

    def ping(self, number: int) -> None:
        """Note that a ping is being sent. Numbers rise."""
        self._pinged = number

    def rests(self, now: float) -> bool:
        """Return whether no pings are needed until the stage is sent something or moves robots."""
        return not self._moves and not self.waits and now > max(self._wrote, self._moved) + REST

    @property
    def waits(self) -> bool:
        """True if the stage has yet to answer a ping."""
        return self._pongs < self._pinged

    def writing(self, now: float) -> None:
        """Note that a message other than a ping is about to be sent."""
        self._wrote = now

    def moving(self, plays: bool, may_move: bool, now: float) -> None:
        """Note that the stage reports whether it moves robots, and whether it moves them or may do so by itself."""
        self._plays, self._moves, self._moved = plays, plays or may_move, now

    def loading(self, number: int | None) -> None:
        """Note that a score is being sent, followed by a ping with this number (None until that is known). Until the
        answer to that ping, the stage may take longer."""
        self._loads_end_with = number

    def pong(self, number: int, now: float) -> None:
        self._answered, self._pongs = now, max(self._pongs, number)
        if number == self._loads_end_with:
            self._loaded = number

    def stopped(self, now: float) -> None:
        """Note that the stage has sent its last message. It may take some time to exit."""
        self._answered = now + END_LIMIT

    def look(self, now: float, real: bool) -> float | None:
        """Return the limit that the stage has exceeded, in seconds; None if it responds. Call this every LOOK_PERIOD.

        `real` is true if its robots are real.
        """
        if now > self._looked + LOOK_PERIOD + PING_PERIOD:
            self._forgiven = now  # we had stalled, which proves nothing about the stage
        self._looked = now
        limit = HANG_LIMIT if real and self._plays else HARMLESS_HANG_LIMIT
        if self._loaded != self._loads_end_with:
            limit = LOADING_LIMIT
        return limit if now - max(self._answered, self._forgiven) > limit else None


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
