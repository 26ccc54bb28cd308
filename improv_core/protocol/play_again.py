"""What it means that something outside asks to play: begin, continue, or play again. Pure functions.

ROS 2's service `~/play` and OSC's `/improv/play` ask for it. Neither can choose a program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.protocol.commands import Restart, Resume
from improv_core.protocol.messages import FromStage, State


@dataclass(frozen=True, slots=True)
class Heard:
    """What a stage has said: the state of what plays (None: nothing has been played), what it waits for, and whether
    it is armed."""

    state: State | None = None
    waits_for: Sequence[str] = ()
    armed: bool = False

    def after(self, message: FromStage) -> Heard:
        """The same, after another message of the stage."""
        if message["type"] == "armed":
            return replace(self, armed=message["armed"])
        if message["type"] == "transport":
            return replace(self, state=message["state"], waits_for=message.get("waits_for", ()))
        return self


class Reply(NamedTuple):
    """What follows: what is asked for, if anything; whether that does what was wanted; and a line about it."""

    request: Resume | Restart | None
    succeeds: bool
    line: str


def play(heard: Heard) -> Reply:
    """What follows if somebody asks to play."""
    if heard.state is None:
        return Reply(None, False, "nothing has been played yet: save or play a program first")
    if heard.waits_for:
        return Reply(None, False, f"robots wait for {' and '.join(heard.waits_for)}")
    if heard.armed:
        return Reply({"type": "resume"}, True, "beginning")
    if heard.state in ("playing", "waiting"):
        return Reply(None, True, "it plays already")
    if heard.state == "paused":
        return Reply({"type": "resume"}, True, "continuing")
    return Reply({"type": "restart"}, True, "playing again from beat 0")
