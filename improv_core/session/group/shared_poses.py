"""Where robots are is told to the stages that move others, which keep theirs apart from them. Nothing here does
anything. Standard library only.

Each stage tells that up to twenty times a second. What comes within a moment is passed on together, or a dozen stages
would be told a thousand times a second.
"""

from __future__ import annotations

import math
from dataclasses import replace

from improv_core.protocol.messages import RobotsSeen
from improv_core.session.group.acts import Act, Decided, SendTo, Times
from improv_core.session.group.state import GroupState

PERIOD = 0.02
"""Seconds between two messages to a stage, at least."""


def seen(group: GroupState, host: str, message: RobotsSeen, now: Times) -> Decided:
    """A stage says where its robots are. Of others it knows nothing."""
    ours = {robot: each for robot, each in message["robots"].items() if group.owns(host, robot)}
    return passed_on(replace(group, seen={**group.seen, **ours}), now)


def due(group: GroupState) -> float:
    """When `passed_on` is to be called, in monotonic seconds; infinite if there is nothing to pass on."""
    return group.passes_on if group.seen else math.inf


def passed_on(group: GroupState, now: Times) -> Decided:
    """Tell each stage where the robots of all others are, if that is due."""
    if now.at < due(group):
        return group, []
    others = {
        host: {robot: each for robot, each in group.seen.items() if not group.owns(host, robot)} for host in group.alive
    }
    acts: list[Act] = [SendTo(host, {"type": "seen", "robots": each}) for host, each in others.items() if each]
    return replace(group, seen={}, passes_on=now.at + PERIOD), acts
