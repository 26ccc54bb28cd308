"""Confirmations of a topic's listeners that they receive commands: when to ask, and when one counts. It never reads a
clock.

A listener that we have found may not have found us yet: in half of the starts of twelve robots, some received nothing
of the first 0.15 to 0.28 s. So each listener gets zeros until it confirms them. Fast DDS asks for a confirmation only
when ten messages are unconfirmed, or every 3 s. So zeros are sent in bursts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

ZEROS = 12
"""The number of zeros in a burst. A publisher keeps ten, and with more Fast DDS asks for a confirmation."""
PERIOD = 0.1
"""Seconds from one burst to the next. Zeros sent earlier would also have to be confirmed."""
SETTLE = 0.2
"""Seconds after which a best-effort listener, which confirms nothing, counts. Commands arrived up to 0.16 s late."""
ANSWER_LIMIT = 10.0
"""Seconds after which a warning names a listener that hasn't confirmed. In four runs on a busy machine, it named one
that heard everything after five."""


@dataclass(frozen=True, slots=True)
class Hearing:
    """The known state of one publisher's listeners. Times are in seconds."""

    listeners: int = 0
    heard: int = 0
    """The number of listeners when all of them counted last."""
    since: float = 0.0
    """The time when the latest listener appeared."""
    earliest: float = 0.0
    """The time before which no listener counts, because others may replace it."""
    asked: float | None = None
    """The time of the latest burst, if any."""
    trusts: bool = False
    """True if listeners found at the first check count at once, because the score can't wait for them."""

    def is_heard(self, moves: bool) -> bool:
        """Return whether all listeners receive us, or if the robot `moves`, those that have confirmed."""
        return self.listeners > 0 and (self.heard >= self.listeners or (moves and self.heard > 0))


def counted(hearing: Hearing, listeners: int, now: float) -> Hearing:
    """Update the state with the number of listeners."""
    if not listeners:
        return Hearing(earliest=hearing.earliest)
    if hearing.trusts:
        return replace(hearing, listeners=listeners, heard=listeners, trusts=False)
    if listeners > hearing.listeners:
        return replace(hearing, listeners=listeners, since=now, asked=None)
    return replace(hearing, listeners=listeners, heard=min(hearing.heard, listeners))


def replaced(now: float) -> Hearing:
    """Return a state in which all listeners may be about to be replaced, as after a reset."""
    return Hearing(earliest=now + SETTLE)


def zeros_to_send(hearing: Hearing, now: float) -> int:
    """The number of zeros to send now. Only robots that stand may get them."""
    if not hearing.listeners or hearing.is_heard(moves=False) or now < hearing.earliest:
        return 0
    return ZEROS if hearing.asked is None or now >= hearing.asked + PERIOD else 0


def may_answer(hearing: Hearing, moves: bool, now: float) -> bool:
    """Return whether a confirmation would count: something was sent since the latest listener was found."""
    waits = hearing.listeners > 0 and not hearing.is_heard(moves) and now >= hearing.earliest
    return waits and (hearing.asked is not None or (moves and now > hearing.since))


def is_overdue(hearing: Hearing, now: float) -> bool:
    """Return whether listeners haven't confirmed for a long time."""
    return hearing.asked is not None and now >= hearing.since + ANSWER_LIMIT


def answered(hearing: Hearing, confirms: bool, now: float) -> Hearing:
    """Update the state once all reliable listeners have confirmed; `confirms` is true if all are reliable."""
    if not confirms and now < hearing.since + SETTLE:
        return hearing
    return replace(hearing, heard=hearing.listeners)
