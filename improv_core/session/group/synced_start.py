"""Chooses the instants at which stages on several machines begin, continue, and obey requests: all at the same one.
Decisions without side effects. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from improv_core.protocol.commands import Resume
from improv_core.session.group.acts import Act, Decided, SendTo, Times
from improv_core.session.group.state import SPARE, GroupState, beat_at

EDGE = 0.01
"""Seconds around a beat in which no instant is chosen, since two stages might take it for another beat."""
DRIFT_PERIOD = 10.0
"""Seconds after which all get the lead's position again: two clocks may drift by 0.1 ms in each."""
RESUME: Resume = {"type": "resume"}
EARLY = 1.0
"""Seconds before the time at which a dance begins by itself, from which on all are sent that time."""


def resume_at(group: GroupState, hosts: Iterable[str], beat: float, at: float, resume: Resume = RESUME) -> Decided:
    """Have paused stages continue from one beat, all at the same time."""
    group = playing_from(group, at)
    acts, timed = list[Act](), resume.copy()
    timed["at"] = at
    for host in hosts:
        if host in group.joining:
            continue
        transport = group.members[host].transport
        if transport and transport["beat"] != beat:
            acts.append(SendTo(host, {"type": "seek", "beat": beat, "at": at}))
        acts.append(SendTo(host, timed))
    return group, acts


def playing_from(group: GroupState, at: float) -> GroupState:
    """Return it with all that are paused playing from this time on."""
    # The pause may have made void what stages that are about to enter were sent: they join again.
    joining = group.joining | group.entering.keys()
    group = replace(group.without_entry(), mode="playing", joining=joining, entering={})
    return replace(group, paused_by=frozenset(), since=at, drifts=at + DRIFT_PERIOD)


def begin(group: GroupState, at: float) -> Decided:
    """Begin at this time with beat 0, for all."""
    group = replace(group.without_entry(), mode="playing", begins=math.inf, since=at, drifts=at + DRIFT_PERIOD)
    return group, [SendTo(host, {"type": "resume", "at": at}) for host in group.alive]


def instant(group: GroupState, now: Times) -> float:
    """Return a time by which all have received a message that is sent now, and that isn't too close to a beat."""
    at, position = now.at + group.ahead, group.position
    if position is None or position["state"] != "playing":
        return at
    beat, edge = beat_at(position, at), EDGE * position["tempo"] / 60
    return at + 2 * EDGE if abs(beat - round(beat)) < edge else at


def settling(group: GroupState, now: Times) -> GroupState:
    """Return it after a request to all: no stage gets the others' position until the result of that is known."""
    known = now.at + 2 * group.ahead + SPARE
    return replace(group, settles=known, drifts=max(group.drifts, known), looks=max(group.looks, known))
