"""Zeros that robots may not have heard: when to send them again, and when to stop. It never reads a clock.

A robot that was told to move is owed a zero until it is known to have heard one: a radio link may be down just when it
is told to stop. Times are in seconds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

PERIOD = 0.2
"""Seconds between two zeros that are owed: slow, so that they cost nothing and disturb nobody."""
UNCONFIRMED = 30.0
"""Seconds for which zeros go to listeners that confirm nothing (best effort). After a cut, Fast DDS needs up to 20 s to
drop a participant, and took up to 3.1 s after the link was back until they had found each other again."""
LATER = 1.0
"""Seconds for which zeros go to a listener that appears later: it hears us up to 0.2 s after we have found it."""
OVERDUE = 5.0
"""Seconds after which a confirmation is overdue: Fast DDS asks for it after ten messages, or every 3 s."""
LIMIT = 60.0
"""Seconds after which nothing more is sent."""


@dataclass(frozen=True, slots=True)
class TopicFacts:
    """What is known of a topic. `others` are other nodes that publish there."""

    listeners: int
    confirms: bool = True
    """Whether all of them are reliable, so that they confirm what they hear."""
    confirmed: bool = False
    """Whether those that are reliable have confirmed all that was sent."""
    others: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Owed:
    """A zero that is owed to the listeners of a topic since a time."""

    since: float
    due: float
    """When to look at it next."""
    expected: int
    """The most listeners that it had: that many have to hear it."""
    listeners: int
    """How many it had at the latest look."""
    until: float
    """Until when zeros go to listeners that confirm nothing."""
    appeared: float
    """When the latest listener appeared, or the robot was told to stop."""
    others: frozenset[str] | None = None
    """Other nodes that published there at the first look."""
    cut: bool = False
    """Whether a confirmation was overdue, so that the link must have been cut."""
    inherited: bool = False
    """Whether somebody else has moved the robot, so that nobody knows how many listeners there were."""

    def sent(self, now: float) -> Owed:
        """After a zero was sent for another reason."""
        return replace(self, due=now + PERIOD)


@dataclass(frozen=True, slots=True)
class FollowUp:
    """What follows from a look: the zero that is still owed, if any, and what to do."""

    owed: Owed | None
    sends: bool = False
    tells: bool = False
    """Whether to tell people that the robot may not have heard it."""


PAID = FollowUp(None)


def owe(now: float, listeners: int, listened: bool, inherited: bool = False) -> Owed:
    """A robot that moved was told to stop. Its topic has this many listeners, and perhaps had some before."""
    expected = listeners or int(listened)
    return Owed(now, now + PERIOD, expected, listeners, now + UNCONFIRMED, now, inherited=inherited)


def look(owed: Owed, now: float, facts: TopicFacts) -> FollowUp:
    """Check whether listeners have heard a zero that is owed, when it is `due`.

    It is paid if all listeners have confirmed it, if those that confirm nothing have been sent it for so long that a
    listener that is still known must have heard it, or if another node has begun to publish there.
    """
    before = facts.others if owed.others is None else owed.others
    comes = facts.listeners > owed.listeners
    if facts.others - before or (comes and facts.others):
        return PAID  # somebody else moves the robot now, and must not be disturbed
    if now >= owed.since + LIMIT:
        heard = owed.inherited and facts.confirmed and facts.listeners >= owed.expected
        return replace(PAID, tells=owed.expected > 0 and not heard)
    owed = replace(
        owed,
        due=now + PERIOD,
        expected=max(owed.expected, facts.listeners),
        listeners=facts.listeners,
        until=max(owed.until, now + LATER) if comes else owed.until,
        appeared=now if comes else owed.appeared,
        others=before,
    )
    if not facts.listeners:
        return FollowUp(owed)
    if not facts.confirmed:
        return FollowUp(replace(owed, cut=owed.cut or now > owed.appeared + OVERDUE), sends=True)
    if owed.appeared > owed.since and now < owed.appeared + LATER:
        return FollowUp(owed, sends=True)
    if not facts.confirms and now < owed.until:
        return FollowUp(owed, sends=True)
    if owed.cut:  # what was confirmed may be from before the link was back: another one has to be, too
        return FollowUp(replace(owed, cut=False, appeared=now), sends=True)
    return PAID if facts.listeners >= owed.expected and not owed.inherited else FollowUp(owed)
