"""The conditions under which real robots may move: emergency stops, a deadman button, robots that have to come back."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

from improv_core.protocol.messages import Pressed
from improv_core.score.score import Safety

GAMEPAD = "the gamepad at the page"
"""The `what` of an edge from a deadman button that somebody holds at the page."""
RELEASED = 0.5
"""Seconds without a true on an emergency stop's topic after which a false counts. Several nodes may publish there, and
one that always sends false must not release what another one presses again and again."""
OLDER = "✗ this save is older than the latest stop: save again"


@dataclass(frozen=True, slots=True)
class StopTopic:
    """The state of an emergency stop's topic, from the messages of its publishers. Times are in seconds."""

    on: bool | None = None
    """True if the stop is on; None before the first message."""
    latest: bool = False
    pressed: float = -math.inf
    """The time of the latest true."""

    def heard(self, values: Iterable[bool], now: float) -> StopTopic:
        """Return the state after these messages: each true presses the stop."""
        heard = [*values]
        if any(heard):
            return StopTopic(True, heard[-1], now)
        return replace(self, on=bool(self.on), latest=False).looked(now)

    def looked(self, now: float) -> StopTopic:
        """Return the state at this time: after a false, the stop is released, unless others still press it."""
        if self.on and not self.latest and now >= self.pressed + RELEASED:
            return replace(self, on=False)
        return self


@dataclass(frozen=True, slots=True)
class EmergencyStops:
    """The topics of emergency stops that are on, even if no score names them, and the number of stops that people may
    not know of when they save: presses of any of them, and stops because the parent was silent."""

    on: frozenset[str] = frozenset()
    count: int = 0

    def heard(self, topic: str, pressed: bool) -> EmergencyStops:
        """Return the stops after one was pressed or released."""
        if pressed == (topic in self.on):
            return self
        return EmergencyStops(self.on | {topic} if pressed else self.on - {topic}, self.count + pressed)

    def counted(self) -> EmergencyStops:
        """Return the stops after the parent was silent, which counts as one."""
        return replace(self, count=self.count + 1)

    def merged(self, pressed: Pressed) -> EmergencyStops:
        """Return the stops that the parent reports from another stage, unless this stage has counted more."""
        return (
            EmergencyStops(self.on | {*pressed["topics"]}, pressed["count"]) if pressed["count"] > self.count else self
        )

    @property
    def message(self) -> Pressed:
        """The message about it for the parent and later stages."""
        return {"type": "pressed", "topics": sorted(self.on), "count": self.count}

    def refusal(self, safety: Safety, known: int | None) -> str | None:
        """Return one line about why a score can't play: a stop is on, or only `known` stops were known when somebody
        asked for the score. None if it can."""
        if self.on:
            return refused_by(self.on, safety.stop)
        return OLDER if known is not None and known < self.count else None


def waits_for(
    safety: Safety, stops: EmergencyStops, held: Collection[str], away: Collection[str], unseen: Collection[str] = ()
) -> list[str]:
    """List the conditions that real robots wait for. `held` are the deadman buttons that people hold, `away` the robots
    that have stopped listening, and `unseen` the robots without a pose that need one."""
    if stops.on:
        return sorted(stops.on)
    may_move = safety.deadman is None or str(safety.deadman) in held or GAMEPAD in held
    return [
        *([] if may_move else [str(safety.deadman)]),
        *(sorted(away) if safety.rejoin == "pause" else []),
        *map(pose_of, sorted(unseen)),
    ]


def pose_of(robot: str) -> str:
    """Return the name of the condition that a robot's pose is known."""
    return f"a pose of {robot}"


def refused_by(on: Collection[str], named: str | None) -> str:
    """Return the message about a score that can't play because emergency stops are on. `named` is the one in its own
    improv.toml, if there is one."""
    others = sorted({*on} - {named})
    if not others:
        return f"✗ the emergency stop on {named} is on: release it, then save again"
    false = f"ros2 topic pub --once {others[0]} std_msgs/msg/Bool '{{data: false}}'"
    return (
        f"✗ the emergency stop on {others[0]} is still on, although improv.toml no longer names it: "
        f"release it (`{false}`) or restart Improv, then save again"
    )
