"""Whether those who listen on a topic are known to hear it: whom to ask, and when they count. It never reads a clock.

A listener that we have found may not have found us yet: in half of the starts of twelve robots, some heard nothing of
the first 0.15 to 0.28 s. So it is sent zeros until it confirms them. Fast DDS asks for a confirmation only when ten
messages wait for one, or every 3 s. So zeros are sent in bursts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

ZEROS = 12
"""How many zeros a listener is asked with at once. A publisher keeps ten: then Fast DDS asks for an answer."""
PERIOD = 0.1
"""Seconds for an answer until the next zeros are sent: more of them in between would have to be confirmed, too."""
SETTLE = 0.2
"""Seconds until one counts that confirms nothing (best effort). Commands arrived up to 0.16 s late until then."""
ANSWER_LIMIT = 5.0
"""Seconds after which one that has not confirmed is named."""


@dataclass(frozen=True, slots=True)
class Hearing:
    """What is known of the listeners of one publisher. Times are in seconds."""

    listeners: int = 0
    heard: int = 0
    """How many of them there were when all counted."""
    since: float = 0.0
    """When the latest one appeared."""
    earliest: float = 0.0
    """Until then none counts, since others may take their place."""
    asked: float | None = None
    """When it was asked last, if it was."""
    trusts: bool = False
    """Whether those that are found at the first look count at once, because nobody can wait for them."""

    def is_heard(self, moves: bool) -> bool:
        """Whether all listeners hear us. While the robot `moves`, those that come to others need not be asked."""
        return self.listeners > 0 and (self.heard >= self.listeners or (moves and self.heard > 0))


def counted(hearing: Hearing, listeners: int, now: float) -> Hearing:
    """After a look at how many there are."""
    if not listeners:
        return Hearing(earliest=hearing.earliest)
    if hearing.trusts:
        return replace(hearing, listeners=listeners, heard=listeners, trusts=False)
    if listeners > hearing.listeners:
        return replace(hearing, listeners=listeners, since=now, asked=None)
    return replace(hearing, listeners=listeners, heard=min(hearing.heard, listeners))


def replaced(now: float) -> Hearing:
    """All of them may be about to be replaced, as after a reset."""
    return Hearing(earliest=now + SETTLE)


def zeros_to_send(hearing: Hearing, now: float) -> int:
    """How many zeros to ask with now. Only robots that stand can be asked."""
    if not hearing.listeners or hearing.is_heard(moves=False) or now < hearing.earliest:
        return 0
    return ZEROS if hearing.asked is None or now >= hearing.asked + PERIOD else 0


def may_answer(hearing: Hearing, moves: bool, now: float) -> bool:
    """Whether an answer would count: something was sent since the latest listener was found."""
    waits = hearing.listeners > 0 and not hearing.is_heard(moves) and now >= hearing.earliest
    return waits and (hearing.asked is not None or (moves and now > hearing.since))


def is_overdue(hearing: Hearing, now: float) -> bool:
    """Whether listeners have been asked for long and don't answer."""
    return hearing.asked is not None and now >= hearing.since + ANSWER_LIMIT


def answered(hearing: Hearing, confirms: bool, now: float) -> Hearing:
    """After those that are reliable have confirmed everything; `confirms` says whether that is all of them."""
    if not confirms and now < hearing.since + SETTLE:
        return hearing
    return replace(hearing, heard=hearing.listeners)
