"""Passes the poses of robots on to the stages that move others, which keep theirs apart from them. Decisions without
side effects. Standard library only.

Each stage reports them up to twenty times a second. Reports within a moment are passed on together, or a dozen stages
would get a thousand messages a second.
"""

from __future__ import annotations

import math
from dataclasses import replace

from improv_core.protocol.messages import RobotsSeen
from improv_core.session.group.acts import Act, Decided, SendTo, Times
from improv_core.session.group.state import GroupState

PERIOD = 0.02
"""The fewest seconds between two messages to a stage."""


def seen(group: GroupState, host: str, message: RobotsSeen, now: Times) -> Decided:
    """Take a stage's report about its robots. It can't know about others."""
    ours = {robot: each for robot, each in message["robots"].items() if group.owns(host, robot)}
    return passed_on(replace(group, seen={**group.seen, **ours}), now)


def due(group: GroupState) -> float:
    """Return the time of the next call of `passed_on`, in monotonic seconds; infinite if there is nothing to pass
    on."""
    return group.passes_on if group.seen else math.inf


def passed_on(group: GroupState, now: Times) -> Decided:
    """Send each stage the poses of all others' robots, if that is due."""
    if now.at < due(group):
        return group, []
    others = {
        host: {robot: each for robot, each in group.seen.items() if not group.owns(host, robot)} for host in group.alive
    }
    acts: list[Act] = [SendTo(host, {"type": "seen", "robots": each}) for host, each in others.items() if each]
    return replace(group, seen={}, passes_on=now.at + PERIOD), acts
