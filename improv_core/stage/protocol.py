"""The messages between a stage, its parent, and its helper processes (docs/protocol.md), and the limits they share.

Standard library only. A message is a plain dict, so it costs nothing to send; the types are for readers of the code and
for mypy. Where a message arrives from another process, `read_to_stage` or `read_from_stage` checks it.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, TypedDict, cast, get_args

from improv_core.plain import message as in_plain_text
from improv_core.score.fits import fits, hints_of
from improv_core.score.motion import Pose

VERSION = 1
"""The protocol's version."""
FOLDER = Path(__file__).resolve().parent
"""What Python is started with to run a stage."""

SLOWEST, FASTEST = 0.1, 4.0
"""Limits of the speed factor."""
LAST_BEAT = 1e15
"""The last beat to which one can seek: beyond it, numbers in JavaScript are no longer exact."""
SILENCE_LIMIT = 0.5
"""Seconds without a ping after which a stage with real robots considers its parent hung, and stops the robots."""
HANG_LIMIT = 0.9
"""Seconds without an answer after which a stage that moves real robots counts as hung. With the ping period, that is
noticed within 1 s. Less would stop healthy stages on a busy machine."""
LOADING_LIMIT = 10.0
"""Seconds that either side may need for a new score: to read a long one, or to make a thousand robots' publishers."""
DEADMAN_LIMIT = 0.3
"""Seconds without a sign of a deadman button after which it counts as released."""
END_LIMIT = 3.0
"""Seconds a stage may take to stop its robots and end, before it is killed."""
LONGEST_TEXT = 100_000
"""The most characters of a program that can be edited on the page: a browser would need too long to lay out more."""

When = Literal["restart", "now", "beat", "bar", "end"]
"""When a score starts: from beat 0 with robots at their starts, or taking over at once, at a beat, bar, or the end."""
State = Literal["waiting", "playing", "paused", "ended", "stopped"]
"""`waiting` means waiting for listeners, before beat 0."""


class PoseJson(TypedDict):
    """A pose in meters and radians."""

    x: float
    y: float
    z: float
    heading: float


def to_pose_json(pose: Pose) -> PoseJson:
    """A pose for a message."""
    return {"x": pose.x, "y": pose.y, "z": pose.z, "heading": pose.heading}


class StartPoseJson(TypedDict):
    """A start pose in meters and degrees, as improv.toml has it."""

    x: float
    y: float
    heading: float


class _Timed(TypedDict, total=False):
    """`at` is the monotonic time at which a request takes effect; without it, that is when it arrives."""

    at: float


class _Instant(TypedDict):
    """A beat, the seconds since beat 0 (`performed`), and the Unix time in nanoseconds (`wall`)."""

    beat: float
    performed: float
    wall: int


class Moment(_Instant):
    """When a robot sensed or decided something in the score of this generation."""

    generation: int
    robot: str


class Sensed(Moment):
    """A sense of a robot has become true or false, or silent (null)."""

    type: Literal["sensed"]
    sense: str
    value: bool | None


class MeasuredRobot(_Instant):
    """Where a robot was (`pose`) and where it ideally would have been (`ideal`).

    `source` is the type of the messages with its poses, or the simulator. `aligned` counts how often the frame of the
    source was aligned with the world of the score: poses with different counts can't be compared. `frame` is the name
    of that frame, and `origin` is where the origin of the world is in it. `follows` tells whether it is pulled back to
    its ideal path.
    """

    source: str
    frame: str
    origin: PoseJson
    pose: PoseJson
    ideal: PoseJson
    aligned: int
    follows: bool


class Measured(TypedDict):
    """Where robots really were, in the world of the score."""

    type: Literal["measured"]
    generation: int
    robots: Mapping[str, MeasuredRobot]


class _Load(TypedDict):
    type: Literal["load"]
    generation: int
    score: Mapping[str, Any]
    when: When
    backend: str


class SceneJson(TypedDict):
    """The scene of a score that plays, counted from 0, and the beat at which it began."""

    index: int
    begins: float


class Begins(TypedDict, total=False):
    """The beats at which parts began, by robot, except those that began at beat 0. They began with `scene`, or with the
    first scene if it isn't given."""

    begins: Mapping[str, float]
    scene: SceneJson


class Entry(Begins):
    """A score took over at this beat, at this monotonic time."""

    beat: float
    monotonic: float


class Load(_Load, _Timed, total=False):
    """Play a score, as `score_json.to_json` writes it. `entry` is when it took over on the stage that leads.

    With `senses`, those of a recording, robots sense these and nothing else.
    """

    beats_per_bar: int
    entry: Entry
    senses: Sequence[Sensed]


class Hush(_Timed):
    type: Literal["hush"]


class Pause(_Timed):
    type: Literal["pause"]


class Resume(_Timed):
    type: Literal["resume"]


class Seek(_Timed):
    type: Literal["seek"]
    beat: float


class Speed(_Timed):
    type: Literal["speed"]
    factor: float


class Silence(_Timed):
    type: Literal["silence"]
    muted: Sequence[str]
    soloed: Sequence[str]


class Held(_Timed):
    """Somebody holds the deadman button of a gamepad at the page; sent repeatedly."""

    type: Literal["held"]


class Released(_Timed):
    """The deadman button at the page was released."""

    type: Literal["released"]


class Cue(_Timed):
    """Somebody gives the cue: the sense `cue` holds for an instant."""

    type: Literal["cue"]


class KeySense(_Timed):
    """Somebody holds the key of a sense, which is sent repeatedly, or releases it."""

    type: Literal["key"]
    key: str
    held: bool


class Force(_Timed):
    """Make a simulated robot sense this, whatever is around it. Null ends that."""

    type: Literal["force"]
    robot: str
    sense: str
    value: bool | None


class Decided(Moment):
    """A word of senses has decided something: `sources` (statement, start, and end of each) ends with that word.

    `held` tells whether its condition was true.
    """

    type: Literal["decided"]
    sources: Sequence[Sequence[int]]
    held: bool


class Problem(TypedDict):
    """What is wrong in a file, where, and the word there. Lines and columns count from 1; line 0 is the whole file."""

    file: str
    line: int
    column: int
    word: str
    message: str


class Program(TypedDict):
    """The program to play, and what keeps it from being played."""

    type: Literal["program"]
    name: str
    folder: str
    problems: Sequence[Problem]


class Source(TypedDict):
    """The program as it stands in its file at `path`, which pages may edit. `revision` names this version of it.

    Its lines end in \\n here, whatever the line ends in the file are.
    """

    type: Literal["source"]
    path: str
    text: str
    revision: str


class Analyze(TypedDict):
    """Asks for the colors and problems of a page's text. The page numbers its texts."""

    type: Literal["analyze"]
    number: int
    text: str


class Complete(TypedDict):
    """Asks what may be written at an offset of the text with this number."""

    type: Literal["complete"]
    number: int
    offset: int


class Explain(TypedDict):
    """Asks what is at an offset of the text with this number."""

    type: Literal["explain"]
    number: int
    offset: int


class Write(TypedDict):
    """Save this text, which is an edit of a revision of the file, and play it."""

    type: Literal["write"]
    number: int
    text: str
    revision: str


AskEditor = Analyze | Complete | Explain | Write
"""What a page asks for while somebody edits the program on it."""


class TextEdit(TypedDict):
    """Replaces the text between two offsets."""

    start: int
    end: int
    text: str


class TextFix(TypedDict):
    title: str
    edits: Sequence[TextEdit]


class TextProblem(TypedDict):
    """A diagnostic of a text or, if `file` is given, of that file, at its `line` (counted from 1)."""

    start: int
    end: int
    file: str
    line: int
    severity: str
    message: str
    fixes: Sequence[TextFix]


class Analyzed(TypedDict):
    """`colors` has three numbers for each colored word: characters since the end of the last one, length, and kind."""

    type: Literal["analyzed"]
    number: int
    colors: Sequence[int]
    problems: Sequence[TextProblem]


class OfferedWord(TypedDict):
    word: str
    about: str


class Completed(TypedDict):
    """The words that may replace the text between two offsets, best first."""

    type: Literal["completed"]
    number: int
    start: int
    end: int
    words: Sequence[OfferedWord]


class Explained(TypedDict):
    """What stands between two offsets, in words, and its path as SVG."""

    type: Literal["explained"]
    number: int
    start: int
    end: int
    text: str
    picture: str


class Written(TypedDict):
    """The text with this number was saved as `revision`, or `problem` says in one line why not."""

    type: Literal["written"]
    number: int
    revision: str
    problem: str


EditorAnswer = Analyzed | Completed | Explained | Written


class Answer(TypedDict):
    """An answer for one page, the one with this number."""

    type: Literal["answer"]
    page: int
    answer: EditorAnswer


class Ping(TypedDict):
    type: Literal["ping"]
    number: int


Conduct = Hush | Pause | Resume | Seek | Speed | Silence | Held | Released | Cue | KeySense | Force
"""What somebody at an editor or a page may do to what plays."""
ToPages = Program | Source | Answer | Measured
"""From the parent to the pages, through their stage."""
ToStage = Load | Conduct | Sensed | Decided | ToPages | Ping


class Restart(TypedDict):
    type: Literal["restart"]


class Place(TypedDict):
    """Robots were dragged to other starts on the page."""

    type: Literal["place"]
    start_poses: Mapping[str, StartPoseJson]


Shape = Literal["line", "circle", "grid"]
Facing = Literal["in", "out"]


class Form(TypedDict):
    """Somebody chose a formation on the page: its distance in meters, and which way robots in a circle face."""

    type: Literal["form"]
    shape: Shape
    distance: float
    facing: Facing


class Watched(TypedDict):
    """Somebody opened a page."""

    type: Literal["watched"]


class Editing(TypedDict):
    """The page with this number asks for something while somebody edits the program on it."""

    type: Literal["editing"]
    page: int
    ask: AskEditor


PageRequest = Conduct | Restart | Place | Form | Editing
"""What somebody may request on the page."""


class _Ready(TypedDict):
    type: Literal["ready"]
    protocol: int
    sink: str
    real: bool


class Ready(_Ready, total=False):
    page: str


class Poses(TypedDict, total=False):
    """Where simulated robots were at beat 0, and are now; nothing for real ones."""

    start: Mapping[str, PoseJson]
    poses: Mapping[str, PoseJson]


class Waiting(TypedDict, total=False):
    """What must change before robots move: an emergency stop, a deadman button, robots that are gone."""

    waits_for: Sequence[str]


class _TransportMessage(TypedDict):
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
    monotonic: float
    wall: float


class TransportMessage(_TransportMessage, Poses, Waiting, Begins):
    """The playback position at the times `monotonic` and `wall`."""


class Request(TypedDict):
    """Somebody at the page asks for something."""

    type: Literal["request"]
    command: PageRequest | Watched


class Sent(TypedDict):
    """A velocity that has been sent."""

    type: Literal["sent"]
    robot: str
    twist: Sequence[float]
    wall: int


class WarningLine(TypedDict):
    type: Literal["warning"]
    message: str


class ErrorLine(TypedDict):
    type: Literal["error"]
    message: str


class Pong(TypedDict):
    type: Literal["pong"]
    number: int


class Lacks(TypedDict):
    """The score of this generation builds on one that the stage doesn't have: it has to be sent whole."""

    type: Literal["lacks"]
    generation: int


class _Stopped(TypedDict):
    type: Literal["stopped"]


class Stopped(_Stopped, Poses, total=False):
    """The stage's last message."""

    message: str


FromStage = (
    Ready
    | TransportMessage
    | Request
    | Sensed
    | Decided
    | Measured
    | Sent
    | WarningLine
    | ErrorLine
    | Pong
    | Lacks
    | Stopped
)


class Publish(TypedDict):
    """The stage has a publisher: `kind` is Twist or TwistStamped, and it may be its second node's."""

    type: Literal["publish"]
    topic: str
    kind: str
    second: bool


class Withdraw(TypedDict):
    """The stage no longer has a publisher."""

    type: Literal["withdraw"]
    topic: str
    kind: str


class Moves(TypedDict):
    """A robot is about to be told to move, by velocities in a frame; `patience` as in `Pulse`."""

    type: Literal["moves"]
    topic: str
    frame: str
    patience: float


class Pulse(TypedDict):
    """The stage lives; if nothing more comes within `patience` seconds, it hangs."""

    type: Literal["pulse"]
    patience: float


class Stands(TypedDict):
    """All robots have been told to stop."""

    type: Literal["stands"]


class EndStandby(TypedDict):
    """The stage ends, and its robots stand."""

    type: Literal["end"]


class SenseToRead(TypedDict):
    """A sense of a robot; `source` as in a score, with a topic."""

    robot: str
    sense: str
    source: Mapping[str, Any]


class Read(TypedDict):
    """Read these senses and the poses of these robots (robot: topic), and no others."""

    type: Literal["read"]
    senses: Sequence[SenseToRead]
    odometry: Mapping[str, str]


class SenseEdge(TypedDict):
    """A sense of a robot has become true or false, or silent (null), at a time on the monotonic clock."""

    type: Literal["edge"]
    robot: str
    sense: str
    value: bool | None
    at: float


class Alive(TypedDict):
    """The reader lives."""

    type: Literal["alive"]


class Unread(TypedDict):
    """A topic can't be read at all; `message` is one line that says why."""

    type: Literal["unread"]
    topic: str
    message: str


class Plays(TypedDict):
    """A score has arrived at the stage, as `score_json.to_json` writes it."""

    type: Literal["plays"]
    generation: int
    score: Mapping[str, Any]


class Health(TypedDict):
    """How well commands reach robots: `late` is the longest delay in seconds, `missing` says why robots can't hear, and
    `clipped` are those whose commands exceeded their limits."""

    type: Literal["health"]
    late: float
    missing: Mapping[str, str]
    clipped: Sequence[str]


ToPublisher = Plays | TransportMessage | Sensed | Measured | WarningLine | ErrorLine | Health
"""From the stage to the process that publishes what plays, over a pipe."""


class MeasuredPose(TypedDict):
    """Where a robot is in the frame of its source (the type of the message), at a time on the monotonic clock."""

    robot: str
    source: str
    frame: str
    pose: PoseJson
    at: float


class MeasuredPoses(TypedDict):
    """The latest poses of robots, at most twenty a second of each."""

    type: Literal["poses"]
    poses: Sequence[MeasuredPose]


ToReader = Read
"""From the stage to the reader of sensors, over a pipe."""
FromReader = SenseEdge | MeasuredPoses | Alive | Unread

ToStandby = Publish | Withdraw | Moves | Pulse | Stands | EndStandby
"""From the stage to its standby, over a pipe."""

SIMULATED = "simulator"
"""The source of poses that need not be measured: the simulator knows where its robots are."""


def beat_at(transport: TransportMessage, now: float) -> float:
    """The beat at a monotonic time, according to a stage's latest transport message."""
    passed = max(now - transport["monotonic"], 0.0) if transport["state"] == "playing" else 0.0
    beat = transport["beat"] + passed * transport["tempo"] / 60
    return beat if transport["beats"] is None else min(beat, transport["beats"])


def is_silent(robot: str, muted: Collection[str], soloed: Collection[str]) -> bool:
    """Whether a robot stands still while others play: if robots are soloed, all others, or else the muted ones."""
    return robot not in soloed if soloed else robot in muted


def refused_by(stop: str) -> str:
    """The message about a score that can't play because an emergency stop is on."""
    return f"✗ the emergency stop on {stop} is on: release it, then save again"


class ProtocolError(Exception):
    """A line is not a valid message here. The text is one plain line that says why."""


def read_to_stage(line: bytes) -> ToStage:
    """The message to a stage that a line holds. Raises ProtocolError."""
    return cast(ToStage, _read(line, ToStage))


def read_from_stage(line: bytes) -> FromStage:
    """The message from a stage that a line holds. Raises ProtocolError."""
    return cast(FromStage, _read(line, FromStage))


def by_type(union: Any) -> dict[str, type]:
    """The messages of a union, or the one message, by `type`."""
    return {get_args(hints_of(each)["type"])[0]: each for each in get_args(union) or [union]}


def _read(line: bytes, union: Any) -> object:
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        raise ProtocolError("this line is not JSON") from None
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str):
        raise ProtocolError("this line is JSON, but not a message: it has no `type`")
    expected = _by_type(union).get(kind)
    if expected is None:
        raise ProtocolError(in_plain_text(f"there is no message `{kind}`"))
    if missing := expected.__required_keys__ - message.keys():  # type: ignore[attr-defined]
        raise ProtocolError(f"`{kind}` needs {' and '.join(f'`{name}`' for name in sorted(missing))}")
    hints = hints_of(expected)
    if wrong := [name for name in hints if name in message and not fits(message[name], hints[name])]:
        raise ProtocolError(f"`{wrong[0]}` of `{kind}` has a wrong value")
    return message


_by_type = lru_cache(by_type)
