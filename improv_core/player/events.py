"""Events of a performance, and the facts at that moment: all that a decision depends on."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.player.agenda import Due
from improv_core.player.return_state import HomeStep
from improv_core.player.sensing import Foreseen
from improv_core.player.start_gate import Gate
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import Automation, Pause, Resume, Seek, Silence, Speed, Stop
from improv_core.protocol.messages import Pressed, When
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
from improv_core.score.transport import BEATS_PER_BAR


@dataclass(frozen=True, slots=True)
class Load:
    """A request to play a score: `restart` from beat 0 and start poses, or take over `now`, at the next `beat` or
    `bar`, or at the `end`.

    A score that takes over is an edit of the one that plays: the beat keeps counting, parts of the same edition play
    on, and all others begin. `entry` has the time of the takeover if another stage has decided it. If playback is
    paused, the score continues from there; if nothing plays, it restarts. If `senses` are given, robots sense only
    these after a restart. A score that moves real robots is refused while an emergency stop is on, or if one was
    pressed after the request, before which there were `stops` presses. One that an automation requests (`by` its name)
    is refused after a stop that wasn't its own. After a restart, a `gate` holds beat 0 back. A score takes over
    `not_before` this time on the clock; one that comes late still takes over when it did in other stages. `backend` is
    the output that plays everything, in words for people (default: the sink's name).
    """

    score: Score
    generation: int
    when: When
    entry: Takeover | None = None
    beats_per_bar: int = BEATS_PER_BAR
    senses: Iterable[Foreseen] | None = None
    stops: int | None = None
    anyway: bool = False
    gate: Gate | None = None
    not_before: float = -math.inf
    by: Automation | None = None
    backend: str = ""


@dataclass(frozen=True, slots=True)
class Restarted:
    """A score has been prepared to play from the beginning."""

    load: Load


@dataclass(frozen=True, slots=True)
class Awaited:
    """Beat 0 has waited for a while."""


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
    that are `leaving` are over. With `goes_on`, the others play on untouched. `entry` is as in `Load`."""

    score: Score
    generation: int
    at: float
    beat: Exact
    entering: Collection[str]
    leaving: Collection[str]
    goes_on: bool
    entry: Takeover | None = None


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """An emergency stop is pressed or released."""

    topic: str
    pressed: bool


@dataclass(frozen=True, slots=True)
class ParentSilent:
    """The parent on this machine was suspended or hung. What it was asked for since then still waits there."""


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
"""The messages that are decided ahead of what is due. Before all others, that is sent, so that robots don't miss it;
but a stop must not wait for it, a seek makes it void, and the others find nothing due."""
Internal = (
    Load | Restarted | Awaited | Listened | Replaced | EmergencyStop | ParentSilent | Changed | Stalled | Overloaded
    | Faults | TooNear | Returning | Anchor | Due
)  # fmt: skip
"""`Anchor` is news of the clock that the stage follows. `Due` is an event that the agenda names: a scene, a takeover,
the end, or a look at a clock."""
Event = Message | Internal


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts that decisions depend on.

    `now` is the time on the clock, and `real` is true if real robots move. Other stages have done the same `late`
    seconds ago, so this one continues from where they are. `over` is the beat at which the last part of this scene is
    over. `away` are robots that no longer listen, and `standing` those that stand until the next play. `held` are the
    deadman buttons that people hold. `poses` are those of simulated robots that senses have moved. `places` are the
    ideal and the measured poses of robots whose poses are in the world. While a gate holds beat 0 back, `wall` is the
    wall clock, in Unix time. `unseen` are robots that must be seen and aren't. `unreached` are robots that have moved
    and are out of reach, as far as is known. `paths` computes ideal poses.
    """

    now: float = 0.0
    real: bool = False
    over: Duration = 0
    late: float = 0.0
    away: frozenset[str] = frozenset()
    standing: frozenset[str] = frozenset()
    held: frozenset[str] = frozenset()
    poses: Mapping[str, Pose] = field(default_factory=dict)
    places: Mapping[str, Standing] = field(default_factory=dict)
    wall: float = 0.0
    unseen: Collection[str] = ()
    unreached: Collection[str] = ()
    paths: Paths = field(default_factory=Paths, compare=False)
