"""What it means that something outside asks to play: begin, continue, or play again. Pure functions.

ROS 2's service `~/play` and OSC's `/improv/play` ask for it. Neither can choose a program.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.protocol.commands import AUTOMATIONS, Automation, Restart, Resume, Stop
from improv_core.protocol.messages import FromStage, State, TransportMessage

STOPPED = "robots were stopped: play again on the page, in the editor, or by saving"
"""Why an automation can't have robots move."""


@dataclass(frozen=True, slots=True)
class Heard:
    """What a stage has said: the state of what plays (None: nothing has been played), what it waits for, whether it is
    armed, and what may have robots move without a person."""

    state: State | None = None
    waits_for: Sequence[str] = ()
    armed: bool = False
    startable_by: Collection[Automation] = AUTOMATIONS

    def after(self, message: FromStage) -> Heard:
        """The same, after another message of the stage."""
        if message["type"] == "armed":
            return replace(self, armed=message["armed"])
        if message["type"] == "transport":
            waits_for, startable_by = message.get("waits_for", ()), message.get("startable_by", AUTOMATIONS)
            return replace(self, state=message["state"], waits_for=waits_for, startable_by=startable_by)
        return self


def stop_of(transport: TransportMessage) -> Stop:
    """The stop that another stage is sent because one has stopped: whose it was counts for all."""
    startable_by = transport.get("startable_by", ())
    return {"type": "stop", "by": startable_by[0]} if len(startable_by) == 1 else {"type": "stop"}


class Reply(NamedTuple):
    """What follows: what is asked for, if anything; whether that does what was wanted; and a line about it."""

    request: Resume | Restart | None
    succeeds: bool
    line: str


def play(heard: Heard, by: Automation) -> Reply:
    """What follows if an automation asks to play. The stage decides whether it may: see `Run.may_start`."""
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
    return Reply({"type": "restart", "by": by}, True, "playing again from beat 0")
