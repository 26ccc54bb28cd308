"""Decides what a request to play from outside does: begin, continue, or play again. Pure functions.

ROS 2's service `~/play` and OSC's `/improv/play` send it. Neither can choose a program.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.protocol.commands import AUTOMATIONS, Automation, Restart, Resume
from improv_core.protocol.messages import FromStage, State

STOPPED = "robots were stopped: play again on the page, in the editor, or by saving"
"""The reason why an automation can't have robots move."""
NOT_READY = "not begun: robots are still waited for; begin once it says `armed`"
"""The answer to a command to begin before all robots are ready."""


@dataclass(frozen=True, slots=True)
class Heard:
    """The latest reports of a stage: the state of playback (None: nothing has been played), the conditions it waits
    for, whether it is armed, and what may have robots move without a person."""

    state: State | None = None
    waits_for: Sequence[str] = ()
    armed: bool = False
    startable_by: Collection[Automation] = AUTOMATIONS

    def after(self, message: FromStage) -> Heard:
        if message["type"] == "armed":
            return replace(self, armed=message["armed"])
        if message["type"] == "transport":
            waits_for, startable_by = message.get("waits_for", ()), message.get("startable_by", AUTOMATIONS)
            return replace(self, state=message["state"], waits_for=waits_for, startable_by=startable_by)
        return self


class Reply(NamedTuple):
    """The answer to a request: the command to send, if any; if that does what was wanted; and a line about it."""

    request: Resume | Restart | None
    succeeds: bool
    line: str


def play(heard: Heard, by: Automation) -> Reply:
    """Return the answer to an automation that asks to play. The stage decides whether it may: see `Run.may_start`."""
    if heard.state is None:
        return Reply(None, False, "nothing has been played yet: save or play a program first")
    if heard.waits_for:
        return Reply(None, False, f"robots wait for {' and '.join(heard.waits_for)}")
    if heard.armed:
        return Reply({"type": "resume", "by": by}, True, "beginning")
    if heard.state in ("playing", "waiting"):
        return Reply(None, True, "it plays already")
    if by not in heard.startable_by:
        return Reply(None, False, STOPPED)
    if heard.state == "paused":
        return Reply({"type": "resume", "by": by}, True, "continuing")
    return Reply({"type": "restart", "by": by}, True, "playing again from the beginning")
