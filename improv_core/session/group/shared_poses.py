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
from improv_core.session.group.state import Troupe

PERIOD = 0.02
"""Seconds between two messages to a stage, at least."""


def seen(troupe: Troupe, host: str, message: RobotsSeen, now: Times) -> Decided:
    """A stage says where its robots are. Of others it knows nothing."""
    ours = {robot: each for robot, each in message["robots"].items() if troupe.owns(host, robot)}
    return passed_on(replace(troupe, seen={**troupe.seen, **ours}), now)


def due(troupe: Troupe) -> float:
    """When `passed_on` is to be called, in monotonic seconds; infinite if there is nothing to pass on."""
    return troupe.passes_on if troupe.seen else math.inf


def passed_on(troupe: Troupe, now: Times) -> Decided:
    """Tell each stage where the robots of all others are, if that is due."""
    if now.at < due(troupe):
        return troupe, []
    others = {
        host: {robot: each for robot, each in troupe.seen.items() if not troupe.owns(host, robot)}
        for host in troupe.alive
    }
    acts: list[Act] = [SendTo(host, {"type": "seen", "robots": each}) for host, each in others.items() if each]
    return replace(troupe, seen={}, passes_on=now.at + PERIOD), acts
