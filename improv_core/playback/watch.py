"""Whether a stage still answers, and whether we ourselves do. Standard library only; times are given."""

from __future__ import annotations

from improv_core.stage.protocol import END_LIMIT, LOADING_LIMIT

PING_PERIOD = 0.1
"""Seconds between two pings. They tell the stage that we live, and the answers tell us that it does."""
LOOK_PERIOD = PING_PERIOD / 4
"""Seconds between two looks at whether the stage hangs."""
HANG_LIMIT = 0.4
"""Seconds without an answer after which a stage counts as hung. With the period of pings, it is noticed in 0.5 s."""
SIMULATED_HANG_LIMIT = 3.0
"""The same for a stage that moves nothing real: on a busy machine it may be late, and harms nobody."""
PULSE_LIMIT = 3.0
"""Seconds our event loop may stand still, as while a huge document is read, until we count as hung ourselves."""


class Watch:
    """Pings and answers of one stage. Times are monotonic, in seconds.

    Three threads use it without a lock, as each field has one thread that writes it: the one that writes to the stage
    (`ping`, `loading`), the one that reads from it (`pong`, `stopped`), and the event loop (`look`).
    """

    def __init__(self, now: float) -> None:
        self._pings = 0  # written by the writer
        self._loads_end_with = 0  # by the writer: the ping behind the latest score
        self._answered = now  # by the reader
        self._pongs = 0  # by the reader: the number of the latest answer
        self._looked = now  # by the event loop
        self._forgiven = now  # by the event loop: until then, it was us who stood still

    def ping(self, now: float) -> int | None:
        """The number of a ping to send now; None if our event loop hangs, as the stage is to notice."""
        if now - self._looked > PULSE_LIMIT:
            return None
        self._pings += 1
        return self._pings

    def loading(self) -> None:
        """A score is being sent, and a ping right behind it: until that is answered, the stage may take its time."""
        self._loads_end_with = self._pings + 1

    def pong(self, number: int, now: float) -> None:
        """The stage has answered a ping."""
        self._answered, self._pongs = now, number

    def stopped(self, now: float) -> None:
        """The stage has said its last word: from here on it takes time to end."""
        self._answered = now + END_LIMIT

    def look(self, now: float, real: bool) -> float | None:
        """The limit that the stage has exceeded, in seconds; None if it answers. To be called every LOOK_PERIOD.

        `real` is whether it moves real robots.
        """
        if now > self._looked + LOOK_PERIOD + PING_PERIOD:
            self._forgiven = now  # we ourselves stood still, which says nothing about the stage
        self._looked = now
        limit = HANG_LIMIT if real else SIMULATED_HANG_LIMIT
        if self._pongs < self._loads_end_with:
            limit = LOADING_LIMIT
        return limit if now - max(self._answered, self._forgiven) > limit else None
