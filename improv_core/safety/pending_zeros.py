"""Zeros that robots may not have received: when to send them again, and when to give up. It never reads a clock.

A radio link may be down just when a robot should stop. So after a robot has moved, its zero is pending until the robot
is known to have received one. Times are in seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

LAST_ZEROS = 3
"""The number of zeros that end a motion. One may be lost; an endless stream would disturb other publishers."""
LINGER = 0.2
"""Seconds for which a publisher stays after its last zero. When it goes, a listener loses what it has not received."""
PERIOD = 0.2
"""Seconds between two tries: slow, so that they cost nothing and disturb nobody."""
UNCONFIRMED = 30.0
"""Seconds for which zeros go to listeners that confirm nothing (best effort). After a cut, Fast DDS needs up to 20 s to
drop a participant, and took up to 3.1 s after the link was back until they had found each other again."""
LATER = 1.0
"""Seconds for which zeros go to a listener that appears later: it receives them up to 0.2 s after we have found it."""
OVERDUE = 5.0
"""Seconds after which a confirmation is overdue: Fast DDS asks for it after ten messages, or every 3 s."""
LIMIT = 60.0
"""Seconds after which to give up."""


@dataclass(frozen=True, slots=True)
class TopicFacts:
    """The facts known about a topic. `others` are other nodes that publish there."""

    listeners: int
    confirms: bool = True
    """True if all listeners are reliable: they confirm what they receive."""
    confirmed: bool = False
    """True if those that are reliable have confirmed all that was sent."""
    others: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class PendingZero:
    """A zero that the listeners of a topic may not have received, since a time."""

    since: float
    due: float
    """The time of the next check."""
    expected: int
    """The most listeners that the topic had: this many have to receive the zero."""
    listeners: int
    """The number of listeners at the latest check."""
    until: float
    """The time until which zeros go to listeners that confirm nothing."""
    appeared: float
    """The time at which the latest listener appeared, or the first zero was sent."""
    others: frozenset[str] | None = None
    """Other nodes that published there at the first check."""
    cut: bool = False
    """True if a confirmation was overdue, so that the link must have been cut."""
    asked: bool = False
    """True once the listeners have been asked to confirm it."""
    inherited: bool = False
    """True if another stage has moved the robot, so that nobody knows how many listeners there were."""

    def sent(self, now: float) -> PendingZero:
        """Return the pending zero after one was sent for another reason."""
        return replace(self, due=now + PERIOD)


@dataclass(frozen=True, slots=True)
class FollowUp:
    """The result of a check: the zero, if it is still pending, and what to do."""

    pending: PendingZero | None
    sends: bool = False
    asks: bool = False
    """True if the listeners must be asked to confirm what is sent, which some connections don't do by themselves."""
    warns: bool = False
    """True if people have to be warned that the robot may not have received it."""


DONE = FollowUp(None)


def pending_zero(now: float, listeners: int, listened: bool, inherited: bool = False) -> PendingZero:
    """Return the pending zero of a robot that moved and was sent a zero now.

    Its topic has this many `listeners`; `listened` is true if it ever had any.
    """
    expected = listeners or int(listened)
    return PendingZero(now, now + PERIOD, expected, listeners, now + UNCONFIRMED, now, inherited=inherited)


def check(pending: PendingZero, now: float, facts: TopicFacts) -> FollowUp:
    """Check whether listeners have received a pending zero, when it is `due`.

    It is done if all listeners have confirmed it, if those that confirm nothing have been sent it for so long that a
    listener that is still known must have received it, or if another node has begun to publish there.
    """
    before = facts.others if pending.others is None else pending.others
    joined = facts.listeners > pending.listeners
    if facts.others - before or (joined and facts.others):
        return DONE  # somebody else moves the robot now, and must not be disturbed
    if now >= pending.since + LIMIT:
        received = pending.inherited and facts.confirmed and facts.listeners >= pending.expected
        return replace(DONE, warns=pending.expected > 0 and not received)
    pending = replace(
        pending,
        due=now + PERIOD,
        expected=max(pending.expected, facts.listeners),
        listeners=facts.listeners,
        until=max(pending.until, now + LATER) if joined else pending.until,
        appeared=now if joined else pending.appeared,
        others=before,
        asked=pending.asked and not joined,
    )
    if not facts.listeners:
        return FollowUp(pending)
    if not facts.confirmed:
        return _again(replace(pending, cut=pending.cut or now > pending.appeared + OVERDUE))
    if pending.appeared > pending.since and now < pending.appeared + LATER:
        return _again(pending)
    if not facts.confirms and now < pending.until:
        return _again(pending)
    if pending.cut:  # the confirmed one may be from before the link was back: another one has to be confirmed, too
        return _again(replace(pending, cut=False, appeared=now, asked=False))
    return DONE if facts.listeners >= pending.expected and not pending.inherited else FollowUp(pending)


def _again(pending: PendingZero) -> FollowUp:
    return FollowUp(replace(pending, asked=True), sends=True, asks=not pending.asked)
