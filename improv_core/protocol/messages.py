"""The messages between a stage and its parent (docs/protocol.md). Standard library only.

A message is a plain dict, so it costs nothing to send; the types are for readers of the code and for mypy. When a
message arrives from another process, `read_as` checks it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypedDict

from improv_core.protocol.clock_messages import AnchorMessage, BendMessage
from improv_core.protocol.commands import Automation, Conduct, PageOpened, PageRequest, Pause, Stop, _Asked, _Timed
from improv_core.protocol.decoding import ProtocolError, read_as
from improv_core.protocol.fields import Patience, PoseJson
from improv_core.protocol.host_messages import Link, ParentLost
from improv_core.protocol.robot_messages import (
    FaultMessage,
    JointPositions,
    Measured,
    Resumes,
    RobotInstant,
    Unreached,
    Vitals,
)
from improv_core.score.json_types import Asleep, Between, Long, Monotonic, NotRequired, UnixNanoseconds, UnixTime
from improv_core.score.score import Score
from improv_core.score.takeover import Begins, Paced, Takeover, Trailing
from improv_core.score.transport import BEATS_PER_BAR

VERSION = 3
"""The protocol's version."""


When = Literal["restart", "now", "beat", "bar", "end"]
"""The start of a score: from beat 0 with robots at their starts, or taking over at once, at a beat, bar, or the end."""
State = Literal["waiting", "playing", "paused", "ended", "stopped"]
"""`waiting` means waiting for listeners, before beat 0."""


class Sensed(RobotInstant):
    """A sense that a robot's part reads has become true, false, or silent (null), or is known to be so when parts
    begin. The simulator beside the stage that leads gets this, too, and senses nothing itself."""

    type: Literal["sensed"]
    sense: str
    value: bool | None


class SeenRobot(TypedDict):
    """A robot's pose in the world that all share, `at` a monotonic time, its `frame` by name, and the velocity it is
    `told`, if any: m/s ahead, to the left, and up, and rad/s."""

    at: Monotonic
    pose: PoseJson
    frame: NotRequired[str]
    told: NotRequired[Annotated[Sequence[Annotated[float, Between(-1000, 1000)]], Long(4, 4)]]


class RobotsSeen(TypedDict):
    """The poses of one stage's real robots, from which stages elsewhere have to keep theirs apart: at most twenty times
    a second, or once a second if only their frames matter. They count for 0.5 s from each `at`."""

    type: Literal["seen"]
    robots: Mapping[str, SeenRobot]


class MisplacedRobot(TypedDict):
    """A robot's ideal and measured place (null: unknown), and the advice about it."""

    place: PoseJson
    pose: PoseJson | None
    line: str


class Misplaced(TypedDict):
    """The robots that are not in their places; without any, all are. Sent again when that changes. Playing `waits`
    until a person plays again."""

    type: Literal["misplaced"]
    generation: int
    waits: bool
    robots: Mapping[str, MisplacedRobot]


class CountJson(TypedDict):
    """A count before beat 0: the number of `beats`, and the seconds of each (`period`)."""

    beats: int
    period: float


class Armed(TypedDict):
    """True if a score is `armed`: everything is ready, and beat 0 waits for a person, or for the time at which it
    `begins` by itself (null: never), in Unix time. The last beats before that may be counted."""

    type: Literal["armed"]
    generation: int
    armed: bool
    begins: UnixTime | None
    count: NotRequired[CountJson]


class Arming(TypedDict, total=False):
    """Wait before beat 0 until a person resumes, or until the wall clock reaches `begins`, in Unix time."""

    begins: Annotated[UnixTime, Between(0, 1e12)]


class Load(_Timed, _Asked):
    """Play a score, as `score_json.to_json` writes it. [Load](#load) has the other fields."""

    type: Literal["load"]
    generation: int
    score: Mapping[str, Any]
    when: When
    backend: str
    anyway: NotRequired[bool]
    arming: NotRequired[Arming]
    asleep: NotRequired[Asleep]
    beats_per_bar: NotRequired[int]
    entry: NotRequired[Takeover]
    here: NotRequired[str]
    patience: NotRequired[Patience]
    senses: NotRequired[Sequence[Sensed]]
    stood: NotRequired[Takeover]
    stops: NotRequired[int]


@dataclass(frozen=True, slots=True)
class Play:
    """A `load` message whose score has been read."""

    load: Load
    score: Score

    @property
    def beats_per_bar(self) -> int:
        return max(self.load.get("beats_per_bar", BEATS_PER_BAR), 1)


class Decided(RobotInstant):
    """A word that reads senses has decided something: `sources` has the statement, start, and end of each word from the
    outermost to this one, and `held` is true if its condition was. Sent by the stage that leads, and to the simulator
    beside it, which performs the same."""

    type: Literal["decided"]
    sources: Sequence[Sequence[int]]
    held: bool


class Problem(TypedDict):
    """A problem in a file, its place, and the word there. Lines and columns count from 1; line 0 is the whole file."""

    file: str
    line: int
    column: int
    word: str
    message: str


class ProgramMessage(TypedDict):
    """The file of the program, and the first twenty `problems` of `count` if it can't be played. `names` are those to
    show for robots: in a class, those of children."""

    type: Literal["program"]
    name: str
    folder: str
    problems: Sequence[Problem]
    count: int
    names: NotRequired[Mapping[str, str]]


class Pressed(TypedDict):
    """An emergency stop was pressed or released, or the parent was silent: the topics of emergency stops that are on,
    and the number of presses of any and of silences. The parent keeps this for later stages: there these stops are on
    until a false is heard. What arrives within a quarter of a second counts as requested before it."""

    type: Literal["pressed"]
    topics: Sequence[str]
    count: int


class Ping(TypedDict):
    """Answer `pong`. Sent on the channel of stops, or on standard input behind each `load`: then the answer comes once
    the score is loaded."""

    type: Literal["ping"]
    number: int


class Obeyed(TypedDict):
    """The stage's robots have been told to stop because of the parent's stop with this `direct`."""

    type: Literal["obeyed"]
    direct: str


class PageMessage(TypedDict):
    """An envelope: the process of the pages hands them this `message`, and no stage opens it."""

    type: Literal["page"]
    message: Mapping[str, Any]


ToStage = (
    Load | Conduct | Sensed | Decided | FaultMessage | RobotsSeen | PageMessage | Pressed | AnchorMessage | BendMessage
    | Ping
)  # fmt: skip


class Ready(TypedDict):
    """The stage's first message. `sink` describes it for people, `real` is true if real robots move, and `page` is the
    address of the simulator's page. If the stage can't start, `error` comes instead, and it ends with code 2."""

    type: Literal["ready"]
    protocol: int
    sink: str
    real: bool
    page: NotRequired[str]


class Poses(TypedDict, total=False):
    """The poses of simulated robots at beat 0, and now; empty for real ones."""

    start: Mapping[str, PoseJson]
    poses: Mapping[str, PoseJson]


class TransportMessage(Poses, Begins, Paced, Trailing):
    """The playback position at the times `monotonic` and `wall`, at every change of state. [Transport](#transport) has
    the other fields."""

    type: Literal["transport"]
    generation: int
    restarted: int
    state: State
    backend: str
    tempo: float
    speed: float
    beats: float | None
    beat: float
    performed: float
    muted: Sequence[str]
    soloed: Sequence[str]
    monotonic: Monotonic
    wall: UnixTime
    waits_for: NotRequired[Sequence[str]]
    too_near: NotRequired[Sequence[str]]
    resumes: NotRequired[Resumes]
    startable_by: NotRequired[Sequence[Automation]]
    bar: NotRequired[int]
    deserted: NotRequired[bool]


class Request(TypedDict):
    """Somebody asks for something at the page, or with a ROS 2 service or parameter: a [command](#commands), or
    `page_opened`. The stage with the node obeys a `stop`, `pause`, or `speed` from ROS 2 at once."""

    type: Literal["request"]
    command: PageRequest | PageOpened


class SentAs(TypedDict):
    """The way in which an output sends a robot's velocities: on which topic, as ROS's arguments remap it, and if with
    stamps, unless that depends on a listener that hasn't been found yet."""

    topic: NotRequired[str]
    stamped: NotRequired[bool]


class Sent(SentAs):
    """With `--report-sent`: a velocity has been sent, before the limits of the robot's profile (`twist`: x, y, z, and
    yaw), or a command to `joints`: the position of each, in radians or meters, and its velocity. `topic` and
    `stamped` are about velocities in ROS 2."""

    type: Literal["sent"]
    robot: str
    twist: NotRequired[Sequence[float]]
    joints: NotRequired[Mapping[str, Sequence[float]]]
    wall: UnixNanoseconds


class WarningLine(TypedDict):
    """A line for people."""

    type: Literal["warning"]
    message: str


class StageWarning(WarningLine):
    """A line for people. If it names robots that are `too_near` to others, these have paused playback."""

    too_near: NotRequired[Sequence[str]]


class ErrorLine(TypedDict):
    """A line for people about something that failed."""

    type: Literal["error"]
    message: str


class Pong(TypedDict):
    """The answer to a `ping`."""

    type: Literal["pong"]
    number: int


class Lacks(TypedDict):
    """The score of this generation builds on one that the stage doesn't have: the parent has to send the whole
    score."""

    type: Literal["lacks"]
    generation: int


class Stopped(Poses):
    """The stage's last message: robots have been told to stop. `message` says what failed, if something did."""

    type: Literal["stopped"]
    message: NotRequired[str]


FromStage = (
    Ready | TransportMessage | Request | Sensed | Decided | Measured | RobotsSeen | FaultMessage | Vitals | Unreached
    | JointPositions | Misplaced | Armed | Sent | Pressed | StageWarning | ErrorLine | ParentLost | Link | Pong | Obeyed
    | Lacks | Stopped
)  # fmt: skip
SIMULATED = "simulator"
"""The source of poses that need no measuring: the simulator knows where its robots are."""


DIRECT = 0
"""The number of a stop on the channel of stops that comes straight from whoever stops robots, and not from the
parent."""


def read_first(line: bytes) -> tuple[Stop | Pause | Ping, int]:
    """Return the message that a line on the channel of stops holds, and its number. Raises ProtocolError."""
    message: Stop | Pause | Ping = read_as(line, Stop | Pause | Ping)
    if (number := _count_in(message, "number")) is None:
        raise ProtocolError("what comes on the channel of stops needs a `number`")
    return message, number


def after(message: Mapping[str, Any]) -> int | None:
    """Return the number of messages that were sent on the channel of stops before this one; None if nobody counts
    them."""
    return _count_in(message, "after")


def _count_in(message: Mapping[str, Any], name: str) -> int | None:
    value = message.get(name)
    return value if type(value) is int else None
