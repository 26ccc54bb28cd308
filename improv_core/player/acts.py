"""What the player can be told to do. Acts decide nothing; `doing.py` does them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.player.events import Event, Load
from improv_core.protocol.messages import Armed, ErrorLine, Misplaced, Pressed, StageWarning
from improv_core.protocol.robot_messages import Unreached
from improv_core.safety.fault_monitor import RobotNews
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Exact
from improv_core.score.score import Score


@dataclass(frozen=True, slots=True)
class Tell:
    """Send a message."""

    message: StageWarning | ErrorLine | Pressed | Misplaced | Armed | Unreached


@dataclass(frozen=True, slots=True)
class TellFaults:
    """Report what is new about the faults of robots, in one line for those of which the same is new."""

    found: Sequence[RobotNews]


@dataclass(frozen=True, slots=True)
class Report:
    """Report the playback position, as of a time on the clock (default: now)."""

    at: float | None = None


@dataclass(frozen=True, slots=True)
class ReportSenses:
    """Report what robots with senses sense, as of a beat and a performance time."""

    beat: Exact
    at: float


@dataclass(frozen=True, slots=True)
class Zero:
    """Stop every robot at once. If one can't be stopped, the others still are."""


@dataclass(frozen=True, slots=True)
class Still:
    """Send robots a zero at performance time 0."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class Meet:
    """Set up the robots of a score before it takes over: at the beat, there is no time for that."""

    score: Score


@dataclass(frozen=True, slots=True)
class PrepareAnew:
    """Get ready to play a score from the beginning: performance time starts over."""

    load: Load


@dataclass(frozen=True, slots=True)
class Listen:
    """Find out who listens, for `Listened`."""

    moving: Collection[str] | None = None


@dataclass(frozen=True, slots=True)
class StartMeasuring:
    """Beat 0 is now: what is measured counts from here."""


@dataclass(frozen=True, slots=True)
class Drop:
    """Drop the next setpoints of these robots."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class SendUntil:
    """Send all that is due up to a performance time."""

    at: float


@dataclass(frozen=True, slots=True)
class Prepare:
    """Get ready for a score that takes over at a performance time, and stop robots that leave."""

    score: Score
    entering: Collection[str]
    at: float


@dataclass(frozen=True, slots=True)
class Dismiss:
    """Forget what these robots play in this scene, or what all of them play."""

    robots: Collection[str] | None = None


@dataclass(frozen=True, slots=True)
class ForgetEdges:
    """Forget the edges that were announced, because playback jumps."""


@dataclass(frozen=True, slots=True)
class Place:
    """Move simulated robots to where they ideally are at a beat. Real ones count as being there. These poses follow
    from the beat; None if they have yet to be found out."""

    beat: Exact
    poses: Mapping[str, Pose] | None = field(default=None, compare=False)


@dataclass(frozen=True, slots=True)
class Begin:
    """Have robots play their parts of this scene from a beat on, starting at a performance time."""

    robots: Collection[str]
    beat: Exact
    at: float


@dataclass(frozen=True, slots=True)
class Resend:
    """Send robots what they do now that they have been muted or unmuted."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class Guide:
    """Tell a robot to move that drives back to its part."""

    robot: str
    twist: Twist


@dataclass(frozen=True, slots=True)
class GoOn:
    """A robot that has driven back goes on with its part."""

    robot: str


@dataclass(frozen=True, slots=True)
class Rest:
    """All robots have been told to stop: measure until they have come to rest."""


@dataclass(frozen=True, slots=True)
class Look:
    """Check robots at once, and report what is found."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class LookSoon:
    """Check robots once everything that is due has been sent."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class LookLater:
    """Look at all robots within a while."""


@dataclass(frozen=True, slots=True)
class Then:
    """Now that all this is done, something has happened. What may fail is done before the run says that it was."""

    event: Event


@dataclass(frozen=True, slots=True)
class Welcome:
    """Robots that stood until the next scene, and listen, play again."""


Act = (
    Tell | TellFaults | Report | ReportSenses | Zero | Still | Meet | PrepareAnew | Listen | StartMeasuring | Drop
    | SendUntil | Prepare | Dismiss | ForgetEdges | Place | Begin | Resend | Rest | Look | LookSoon | LookLater | Then
    | Welcome | Guide | GoOn
)  # fmt: skip
