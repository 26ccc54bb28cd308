"""Acts that a decision can ask for. They decide nothing; `apply.py` does them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.player.events import Event
from improv_core.protocol.messages import Armed, ErrorLine, Misplaced, Play, Pressed, StageWarning
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
    """Report news about faults, in one line for all robots with the same news."""

    found: Sequence[RobotNews]


@dataclass(frozen=True, slots=True)
class Report:
    """Report the playback position, as of a time on the clock (default: now)."""

    at: float | None = None


@dataclass(frozen=True, slots=True)
class ReportSenses:
    """Report the senses that open parts read, as of a beat and a performance time."""

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
class CreatePublishers:
    """Create publishers for a score's robots before it takes over: at its beat, there is no time for that."""

    score: Score


@dataclass(frozen=True, slots=True)
class PrepareRestart:
    """Get ready to play a score from the beginning: performance time starts over."""

    play: Play


@dataclass(frozen=True, slots=True)
class Listen:
    """Find the robots that listen, for `Listened`."""

    moving: Collection[str] | None = None


@dataclass(frozen=True, slots=True)
class StartMeasuring:
    """Measure from here on: beat 0 is now."""


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
    """Forget the parts of these robots in this scene, or all parts."""

    robots: Collection[str] | None = None


@dataclass(frozen=True, slots=True)
class ForgetEdges:
    """Forget the edges that were announced, because playback jumps."""


@dataclass(frozen=True, slots=True)
class Place:
    """Move simulated robots to their ideal poses at a beat. Real ones count as being there. `poses` are these poses, or
    None if they have yet to be computed."""

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
    """Send robots their current velocity again, such as after they are muted or unmuted."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class DriveBack:
    """Send a velocity to a robot that drives back to its part."""

    robot: str
    twist: Twist


@dataclass(frozen=True, slots=True)
class Rejoin:
    """Have a robot that has driven back play its part again."""

    robot: str


@dataclass(frozen=True, slots=True)
class Rest:
    """Measure until robots that were sent a stop have come to rest."""


@dataclass(frozen=True, slots=True)
class CheckNow:
    """Check robots at once, and report problems."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class CheckSoon:
    """Check robots once everything that is due has been sent."""

    robots: Collection[str]


@dataclass(frozen=True, slots=True)
class CheckLater:
    """Check all robots again soon, within one period."""


@dataclass(frozen=True, slots=True)
class Then:
    """Take an event once the acts before it are done. So the run changes only after acts that may fail."""

    event: Event


@dataclass(frozen=True, slots=True)
class ReadmitRobots:
    """Let robots play again that stood until this scene, if they listen."""


Act = (
    Tell | TellFaults | Report | ReportSenses | Zero | Still | CreatePublishers | PrepareRestart | Listen
    | StartMeasuring | Drop | SendUntil | Prepare | Dismiss | ForgetEdges | Place | Begin | Resend | Rest | CheckNow
    | CheckSoon | CheckLater | Then | ReadmitRobots | DriveBack | Rejoin
)  # fmt: skip
