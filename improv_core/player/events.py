"""Events of a performance, and the facts at that moment: all that a decision depends on."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.player.agenda import Due
from improv_core.player.returning import HomeStep
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import Pause, Resume, Seek, Silence, Speed, Stop
from improv_core.protocol.messages import Play, Pressed
from improv_core.protocol.robot_messages import FaultMessage
from improv_core.safety.fault_monitor import RobotNews
from improv_core.safety.preflight import Standing
from improv_core.safety.separation import Near
from improv_core.score.motion import Pose
from improv_core.score.movement import Duration, Exact
from improv_core.score.path import Paths
from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Score
from improv_core.score.takeover import Takeover


@dataclass(frozen=True, slots=True)
class Restarted:
    """A score has been prepared to play from the beginning."""

    play: Play


@dataclass(frozen=True, slots=True)
class Awaited:
    """Beat 0 has waited for a while."""

    late: float = 0.0
    """Seconds by which this check comes too late because the stage hung."""


@dataclass(frozen=True, slots=True)
class Listened:
    """Robots were `found` to listen now. If it `waits`, beat 0 waits for others. `moving` are robots that must not keep
    moving meanwhile; None if they were already stopped. `deaf` are those that don't listen. `overdue` is true once,
    when they should by now."""

    found: Collection[str]
    waits: bool
    moving: Collection[str] | None
    deaf: Collection[str] = ()
    overdue: bool = False


@dataclass(frozen=True, slots=True)
class Replaced:
    """A score has been prepared to take over at a performance time. The parts of `entering` begin, and those of robots
    that are `leaving` are over. With `keeps_playing`, the others play on untouched. `entry` has its time if
    another stage has decided it."""

    score: Score
    generation: int
    at: float
    beat: Exact
    entering: Collection[str]
    leaving: Collection[str]
    keeps_playing: bool
    entry: Takeover | None = None


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """An emergency stop is pressed or released."""

    topic: str
    pressed: bool


@dataclass(frozen=True, slots=True)
class Halted:
    """Robots had to be stopped, and nobody asked for that. If the stop `counts`, the parent on this machine was
    suspended or hung, and what it was asked for since then still waits there."""

    counts: bool = False


@dataclass(frozen=True, slots=True)
class Changed:
    """A condition for moving may have changed: a deadman button, the robots that listen, or where robots stand."""


@dataclass(frozen=True, slots=True)
class Stalled:
    """Setpoints for real robots are late by this many seconds."""

    seconds: float


@dataclass(frozen=True, slots=True)
class Overloaded:
    """This machine can't keep up, even at the lowest rate."""


@dataclass(frozen=True, slots=True)
class Faults:
    """News about the faults of real robots."""

    found: Sequence[RobotNews]


@dataclass(frozen=True, slots=True)
class TooNear:
    """These pairs of real robots are too near to each other, the nearest first."""

    found: Sequence[Near]


@dataclass(frozen=True, slots=True)
class Returning:
    """The next steps of robots that drive back to their parts."""

    steps: Sequence[HomeStep]


Message = Stop | Pause | Resume | Seek | Speed | Silence | Pressed | BendMessage | FaultMessage
"""The messages to a stage that its player decides about."""
AHEAD_OF_DUE = frozenset({"stop", "resume", "seek", "pressed"})
"""The messages that are decided before the setpoints that are due. Other messages wait until these setpoints have been
sent, so that robots don't miss them. But a stop must not wait, a seek makes them void, and with the other two of these
messages nothing is due."""
Internal = (
    Play | Restarted | Awaited | Listened | Replaced | EmergencyStop | Halted | Changed | Stalled | Overloaded
    | Faults | TooNear | Returning | Anchor | Due
)  # fmt: skip
"""`Anchor` is news of the clock that the stage follows. `Due` is an event that the agenda names: a scene, a takeover,
the end, or a check of a clock."""
Event = Message | Internal


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts that decisions depend on."""

    now: float = 0.0
    """The time on the clock."""
    real: bool = False
    """True if real robots move."""
    over: Duration = 0
    """The beat at which the last part of this scene is over."""
    late: float = 0.0
    """Seconds since other stages did the same; this one continues from where they are."""
    away: frozenset[str] = frozenset()
    """Robots that no longer listen."""
    standing: frozenset[str] = frozenset()
    """Robots that stand until the next play."""
    held: frozenset[str] = frozenset()
    """The deadman buttons that people hold."""
    poses: Mapping[str, Pose] = field(default_factory=dict)
    """The poses of simulated robots that senses have moved."""
    places: Mapping[str, Standing] = field(default_factory=dict)
    """The ideal and the measured poses of robots whose poses are in the world."""
    wall: float = 0.0
    """The wall clock, in Unix time, while a gate holds beat 0 back."""
    unseen: Collection[str] = ()
    """Robots that must be seen and aren't."""
    unreached: Collection[str] = ()
    """Robots that have moved and are out of reach, as far as is known."""
    other_publishers: Mapping[str, Collection[str]] = field(default_factory=dict)
    """Robots that others can also move, each with the names of these others."""
    unheard: bool = False
    """True if no real robot has listened."""
    paths: Paths = field(default_factory=Paths, compare=False)
    """Computes ideal poses."""
