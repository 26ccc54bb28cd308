"""What happens to a performance, and what is known at that moment: all that a decision depends on."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.player.agenda import Due
from improv_core.player.return_state import HomeStep
from improv_core.player.sensing import Foreseen
from improv_core.player.start_gate import Gate
from improv_core.protocol.commands import Automation
from improv_core.protocol.messages import Takeover, When
from improv_core.safety.fault_monitor import RobotNews
from improv_core.safety.preflight import Standing
from improv_core.safety.separation import Near
from improv_core.score.motion import Pose
from improv_core.score.movement import Duration, Exact
from improv_core.score.path import Paths
from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Score
from improv_core.score.transport import BEATS_PER_BAR


@dataclass(frozen=True, slots=True)
class Load:
    """A score should play. See `Player.load`."""

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
    """Robots `found` to listen now, and whether beat 0 still waits for others. `moving` are those that must not keep
    moving meanwhile; None if they have been told already. `deaf` are those that don't listen; `overdue` says that they
    should by now, once."""

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
    """All robots should stop, `by` the wish of an automation, or of anything else (None)."""

    by: Automation | None = None


@dataclass(frozen=True, slots=True)
class Pause:
    """All robots should stop, and resume from here later."""


@dataclass(frozen=True, slots=True)
class Resume:
    """A pause is over, or an armed score should begin, `by` the wish of an automation, or of a person (None). With
    `anyway`, it doesn't matter where robots stand. Other stages went on `late` seconds ago."""

    anyway: bool = False
    late: float = 0.0
    by: Automation | None = None


@dataclass(frozen=True, slots=True)
class Seek:
    """Playback should continue at another beat. Other stages jumped to it `late` seconds ago."""

    beat: float
    late: float = 0.0


@dataclass(frozen=True, slots=True)
class Speed:
    """Playback should be this many times as fast as the tempo says. Other stages changed `late` seconds ago."""

    factor: float
    late: float = 0.0


@dataclass(frozen=True, slots=True)
class Silence:
    """These robots are muted, and these soloed."""

    muted: Collection[str]
    soloed: Collection[str]


@dataclass(frozen=True, slots=True)
class EmergencyStop:
    """An emergency stop is pressed or released."""

    topic: str
    pressed: bool


@dataclass(frozen=True, slots=True)
class Changed:
    """What robots wait for may have changed: a deadman button, or who listens."""


@dataclass(frozen=True, slots=True)
class Stood:
    """Robots that are not in their places were measured again."""


@dataclass(frozen=True, slots=True)
class Stalled:
    """Real robots should have been sent something this many seconds ago."""

    seconds: float


@dataclass(frozen=True, slots=True)
class Overloaded:
    """This machine can't keep up, even at the lowest rate."""


@dataclass(frozen=True, slots=True)
class Faults:
    """What is new about the faults of real robots."""

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
    """What robots do that drive back to their parts."""

    steps: Sequence[HomeStep]


@dataclass(frozen=True, slots=True)
class Anchored:
    """Something is heard of the clock that is followed. At a rate of 0, it stands."""

    anchor: Anchor


@dataclass(frozen=True, slots=True)
class Bend:
    """The stage that leads was at a beat at a time on the clock, and plays at this pace since then."""

    pace: float
    beat: float
    at: float


Event = (
    Load | Restarted | Awaited | Listened | Replaced | Stop | Pause | Resume | Seek | Speed | Silence
    | EmergencyStop | Changed | Stood | Stalled | Overloaded | Faults | Stand | TooNear | Returning
    | Anchored | Bend | Due
)  # fmt: skip
"""`Due` is something that the agenda says is due: a scene, a takeover, the end, or a look at a clock."""


@dataclass(frozen=True, slots=True)
class Facts:
    """What is known when something is decided.

    `now` is the time on the clock, and `real` whether real robots move. `over` is the beat at which the last part of
    this scene is over. `away` are robots that no longer listen, and `standing` those that stand until the next play.
    `held` are the deadman buttons that are held. `poses` are where simulated robots are that senses have moved,
    and `places` where robots should be and stand whose poses are in the world. While a gate holds
    beat 0 back, `wall` is the wall clock, in Unix time. `unseen` are robots that must be seen and aren't.
    `unreached` are robots that have moved and are out of reach, as far as is known. `paths` knows where robots ideally
    are.
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
