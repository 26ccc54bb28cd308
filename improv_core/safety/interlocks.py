"""What has to change before real robots may move: an emergency stop, a deadman button, robots that are waited for."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

from improv_core.protocol.messages import Pressed, refused_by
from improv_core.score.score import Safety

GAMEPAD = "the gamepad at the page"
"""What an edge is about that comes from the page: a deadman button that is held there."""
RELEASED = 0.5
"""Seconds without a true on an emergency stop's topic after which a false counts: several may publish there, and one
that says false all the time must not release what another one presses again and again."""
OLDER = "✗ this save is older than the emergency stop: save again"


@dataclass(frozen=True, slots=True)
class StopTopic:
    """What the publishers of an emergency stop say. Times are in seconds."""

    on: bool | None = None
    """Whether it is on; None if nobody has said anything."""
    latest: bool = False
    pressed: float = -math.inf
    """When a true came last."""

    def heard(self, values: Iterable[bool], now: float) -> StopTopic:
        """After these messages: each true stops."""
        heard = [*values]
        if not heard:
            return self
        if any(heard):
            return StopTopic(True, heard[-1], now)
        return replace(self, on=bool(self.on), latest=False).looked(now)

    def looked(self, now: float) -> StopTopic:
        """Its state at this time: a false that came last releases it, but not while others press it."""
        if self.on and not self.latest and now >= self.pressed + RELEASED:
            return replace(self, on=False)
        return self


@dataclass(frozen=True, slots=True)
class EmergencyStops:
    """The topics of emergency stops that are on, whether or not a score names them, and how often any was pressed."""

    on: frozenset[str] = frozenset()
    count: int = 0

    def heard(self, topic: str, pressed: bool) -> EmergencyStops:
        """After one was pressed or released."""
        if pressed == (topic in self.on):
            return self
        return EmergencyStops(self.on | {topic} if pressed else self.on - {topic}, self.count + pressed)

    def told(self, pressed: Pressed) -> EmergencyStops:
        """After the parent has told what another stage heard. What this stage has heard since counts more."""
        return (
            EmergencyStops(self.on | {*pressed["topics"]}, pressed["count"]) if pressed["count"] > self.count else self
        )

    @property
    def message(self) -> Pressed:
        """What the parent and later stages are told."""
        return {"type": "pressed", "topics": sorted(self.on), "count": self.count}

    def refusal(self, safety: Safety, known: int | None) -> str | None:
        """Why a score can't play, in one line: one is on, or the score was asked for when only so many were known."""
        if self.on:
            return refused_by(self.on, safety.stop)
        return OLDER if known is not None and known < self.count else None


def waits_for(
    safety: Safety, stops: EmergencyStops, held: Collection[str], away: Collection[str], unseen: Collection[str] = ()
) -> list[str]:
    """What real robots wait for, by these rules. `held` are the deadman buttons that are held, `away` the robots that
    have stopped listening, and `unseen` those that must be seen and aren't."""
    if stops.on:
        return sorted(stops.on)
    may_move = safety.deadman is None or str(safety.deadman) in held or GAMEPAD in held
    return [
        *([] if may_move else [str(safety.deadman)]),
        *(sorted(away) if safety.rejoin == "pause" else []),
        *map(pose_of, sorted(unseen)),
    ]


def pose_of(robot: str) -> str:
    """What is waited for until it is known where a robot is."""
    return f"a pose of {robot}"
