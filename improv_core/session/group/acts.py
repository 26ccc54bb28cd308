"""The acts that a decision about stages on several machines can request, and the times of decisions. Standard library
only."""

from __future__ import annotations

from dataclasses import dataclass

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.messages import ToStage
from improv_core.session.group.state import GroupState


@dataclass(frozen=True, slots=True)
class Times:
    """The monotonic time, and Unix time."""

    at: float
    wall: float = 0.0


@dataclass(frozen=True, slots=True)
class SendTo:
    """Send a message to the stage of a host."""

    host: str
    message: ToStage


@dataclass(frozen=True, slots=True)
class Say:
    """Pass a message to the parent, which takes all stages for one."""

    message: Heard


@dataclass(frozen=True, slots=True)
class StartHost:
    """Start the stage of a host again."""

    host: str


Act = SendTo | Say | StartHost
Decided = tuple[GroupState, list[Act]]


def warning(line: str) -> Say:
    """Return a line for people, no matter which stage it is about."""
    return Say({"type": "warning", "message": line})
