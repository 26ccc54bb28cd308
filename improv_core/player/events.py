"""Events of a performance, and the facts at that moment: all that a decision depends on."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.player.agenda import Due
from improv_core.player.return_state import HomeStep
from improv_core.player.sensing import Foreseen
from improv_core.player.start_gate import Gate
from improv_core.protocol.commands import Automation
from improv_core.protocol.messages import When
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
    """A request to play a score. See `Player.load`."""

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
    late: float = 0.0
    by: Automation | None = None


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
class Stop:
    """A request to stop all robots, made `by` an automation, or by anything else (None)."""

    by: Automation | None = None


@dataclass(frozen=True, slots=True)
class Pause:
    """A request to stop all robots, and to resume from here later."""


@dataclass(frozen=True, slots=True)
class Resume:
    """A request to end a pause, or to begin an armed score, made `by` an automation, or by a person (None). With
    `anyway`, robots need not be in their places. Other stages continued `late` seconds ago."""

    anyway: bool = False
    late: float = 0.0
    by: Automation | None = None


@dataclass(frozen=True, slots=True)
class Seek:
    """A request to continue at another beat. Other stages jumped to it `late` seconds ago."""

    beat: float
    late: float = 0.0


@dataclass(frozen=True, slots=True)
class Speed:
    """A request to play this many times as fast as the score's tempo. Other stages changed `late` seconds ago."""

    factor: float
    late: float = 0.0


@dataclass(frozen=True, slots=True)
class Silence:
    """The robots that are muted now, and those that are soloed."""

    muted: Collection[str]
    soloed: Collection[str]


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """An emergency stop is pressed or released."""

    topic: str
    pressed: bool


@dataclass(frozen=True, slots=True)
class Changed:
    """A condition for moving may have changed: a deadman button, or the robots that listen."""


@dataclass(frozen=True, slots=True)
class Stood:
    """Robots that are not in their places were measured again."""


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
class Stand:
    """A real robot stands because of a fault, so the simulated one that shows it stands too."""

    robot: str


@dataclass(frozen=True, slots=True)
class TooNear:
    """These pairs of real robots are too near to each other, the nearest first."""

    found: Sequence[Near]


@dataclass(frozen=True, slots=True)
class Returning:
    """The next steps of robots that drive back to their parts."""

    steps: Sequence[HomeStep]


@dataclass(frozen=True, slots=True)
class Anchored:
    """News of the clock that the stage follows. At a rate of 0, that clock stands."""

    anchor: Anchor


@dataclass(frozen=True, slots=True)
class Bend:
    """The stage that leads was at a beat at a time on the clock, and has played at this pace since then."""

    pace: float
    beat: float
    at: float


Event = (
    Load | Restarted | Awaited | Listened | Replaced | Stop | Pause | Resume | Seek | Speed | Silence
    | EmergencyStop | Changed | Stood | Stalled | Overloaded | Faults | Stand | TooNear | Returning
    | Anchored | Bend | Due
)  # fmt: skip
"""`Due` is an event that the agenda names: a scene, a takeover, the end, or a look at a clock."""


@dataclass(frozen=True, slots=True)
class Facts:
    """Facts that decisions depend on.

    `now` is the time on the clock, and `real` is true if real robots move. `over` is the beat at which the last part of
    this scene is over. `away` are robots that no longer listen, and `standing` those that stand until the next play.
    `held` are the deadman buttons that people hold. `poses` are those of simulated robots that senses have moved.
    `places` are the ideal and the measured poses of robots whose poses are in the world. While a gate holds beat 0
    back, `wall` is the wall clock, in Unix time. `unseen` are robots that must be seen and aren't. `unreached` are
    robots that have moved and are out of reach, as far as is known. `paths` computes ideal poses.
    """

    now: float = 0.0
    real: bool = False
    over: Duration = 0
    away: frozenset[str] = frozenset()
    standing: frozenset[str] = frozenset()
    held: frozenset[str] = frozenset()
    poses: Mapping[str, Pose] = field(default_factory=dict)
    places: Mapping[str, Standing] = field(default_factory=dict)
    wall: float = 0.0
    unseen: Collection[str] = ()
    unreached: Collection[str] = ()
    paths: Paths = field(default_factory=Paths, compare=False)
