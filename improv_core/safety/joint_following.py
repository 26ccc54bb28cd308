"""Finds joints of real robots that don't follow the program, and the likely cause. Pure functions.

Positions are in radians or meters, times in seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.protocol.output import Unfollowed
from improv_core.safety.joint_preflight import NEAR_SLIDE, NEAR_TURN
from improv_core.score.body import Joint

PATIENCE = 1.0
"""Seconds for which a joint may be told to move without following."""
SHARE = 0.5
"""A joint follows if it covers this share of its way. Less than that is no lag."""


class _Span(NamedTuple):
    """The least and the greatest of some positions."""

    least: float
    most: float

    def to(self, position: float) -> _Span:
        return _Span(min(self.least, position), max(self.most, position))

    @property
    def length(self) -> float:
        return self.most - self.least


@dataclass(frozen=True, slots=True)
class JointWatch:
    """A joint since it followed last, or since its last second without following: the time for which it was told to
    move, and the positions at which the program had it and at which it was measured; None before the first.

    It `has_followed` at some time, hasn't followed for `failing` seconds now, and is told to move at this `speed`.
    """

    told: float = 0.0
    program: _Span | None = None
    measured: _Span | None = None
    has_followed: bool = False
    failing: float = 0.0
    speed: float = 0.0


def watched(
    watch: JointWatch, joint: Joint, seconds: float, position: float, speed: float, measured: float | None, lag: float
) -> JointWatch:
    """Return the watch of a joint that was told to move for some seconds.

    The program has it at `position` now, and moves it on at `speed`. None as `measured` is an unknown position. `lag`
    are the seconds that it needs to follow.
    """
    program = (watch.program or _Span(position, position)).to(position)
    span = watch.measured
    if measured is not None:
        span = (span or _Span(measured, measured)).to(measured)
    watch = replace(watch, told=watch.told + seconds, program=program, measured=span, speed=abs(speed))
    renewed = replace(watch, told=0.0, program=_Span(position, position), measured=None)
    if measured is not None:
        renewed = replace(renewed, measured=_Span(measured, measured))
    if program.length < (NEAR_SLIDE if joint.slides else NEAR_TURN):
        return watch
    if span and span.length >= SHARE * program.length:
        return replace(renewed, has_followed=True, failing=0.0)
    return replace(renewed, failing=watch.failing + watch.told) if watch.told >= PATIENCE + lag else watch


def unfollowed(
    watches: Mapping[str, JointWatch], joints: Mapping[str, Joint], measured: Mapping[str, float], name: str, topic: str
) -> Unfollowed | None:
    """Return the joints of this controller that don't follow; None if all do. Their positions come on `topic`."""
    failing = {joint: watch for joint, watch in watches.items() if watch.failing}
    if not failing:
        return None
    seconds = max(watch.failing for watch in failing.values())
    first = next(iter(failing))
    limit = joints[first].max_velocity
    if first not in measured:
        why = f"no position of {first} comes on {topic}: check the node that publishes it"
    elif limit is not None and SHARE * failing[first].speed > limit:
        why = f"the program asks {first} for far more than its `max_velocity`: `improv check` shows the place"
    elif len(failing) < len(watches) or any(watch.has_followed for watch in failing.values()):
        named = ", ".join(failing)
        why = f"{name} no longer moves {named}: look for what holds {'it' if len(failing) == 1 else 'them'} back"
    else:
        why = f"{name} moves nothing: its log says if it is inactive or refuses what it gets"
    return Unfollowed(seconds, why)
