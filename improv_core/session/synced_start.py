"""Chooses the instants at which stages on several machines begin, continue, and obey requests: all at the same one.
Decisions without side effects. Standard library only."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from improv_core.protocol.commands import Resume
from improv_core.session.acts import Act, Decided, Now, send
from improv_core.session.state import SessionState
from improv_core.session.together import SPARE, ahead, beat_at, position, without_entry

EDGE = 0.01
"""Seconds around a beat in which no instant is chosen, since two stages might take it for another beat."""
DRIFT_PERIOD = 10.0
"""Seconds after which all get the lead's position again: two clocks may drift by 0.1 ms in each."""
RESUME: Resume = {"type": "resume"}
EARLY = 1.0
"""Seconds before the time at which a dance begins by itself, from which on all are sent that time."""


def resume_at(state: SessionState, hosts: Iterable[str], beat: float, at: float, resume: Resume = RESUME) -> Decided:
    """Have paused stages continue from one beat, all at the same time."""
    state = playing_from(state, at)
    acts, timed = list[Act](), resume.copy()
    timed["at"] = at
    for host in hosts:
        if host in state.joining:
            continue
        transport = state.robots[host].transport
        if transport and transport["beat"] != beat:
            acts.append(send(host, {"type": "seek", "beat": beat, "at": at}))
        acts.append(send(host, timed))
    return state, acts


def playing_from(state: SessionState, at: float) -> SessionState:
    """Return it with all that are paused playing from this time on."""
    # The pause may have made void what stages that are about to enter were sent: they join again.
    joining = state.joining | state.entering.keys()
    state = replace(without_entry(state), mode="playing", joining=joining, entering={})
    return replace(state, paused_by=frozenset(), since=at, drifts=at + DRIFT_PERIOD)


def begin(state: SessionState, at: float) -> Decided:
    """Begin at this time with beat 0, for all."""
    state = replace(without_entry(state), mode="playing", since=at, drifts=at + DRIFT_PERIOD)
    return state, [send(host, {"type": "resume", "at": at}) for host in state.alive]


def instant(state: SessionState, now: Now) -> float:
    """Return a time by which all have received a message that is sent now, and that isn't too close to a beat."""
    at, lead = now.at + ahead(state), position(state)
    if lead is None or lead["state"] != "playing":
        return at
    beat, edge = beat_at(lead, at), EDGE * lead["tempo"] / 60
    return at + 2 * EDGE if abs(beat - round(beat)) < edge else at


def settling(state: SessionState, now: Now) -> SessionState:
    """Return it after a request to all: no stage gets the others' position until the result of that is known."""
    known = now.at + 2 * ahead(state) + SPARE
    return replace(state, settles=known, drifts=max(state.drifts, known), looks=max(state.looks, known))
