"""The messages about a program that somebody writes on the page. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict

from improv_core.protocol.fields import (
    Beat,
    Count,
    Distance,
    DrawnPoints,
    Facing,
    Held,
    Name,
    Parts,
    Place,
    Shape,
    SongTime,
    StartPoseJson,
    StartPoses,
    Steps,
    Text,
)
from improv_core.protocol.robot_messages import RobotLook
from improv_core.score.json_types import NotRequired

MAX_PAGES = 64
"""The most pages that can be open. The text of each is kept."""


class ProgramSource(TypedDict):
    """The program as it is in its file at `path`, which pages may edit. `revision` names this version of it. Its lines
    end in \\n here, whatever the line ends in the file are. `toml` is the text of its `improv.toml`."""

    type: Literal["source"]
    path: str
    text: str
    revision: str
    toml: str


class Analyze(TypedDict):
    """Asks for the colors and problems of a page's text. The page numbers its texts, and has the colors of the `known`
    one."""

    type: Literal["analyze"]
    number: Count
    text: Text
    known: NotRequired[Count]


class Complete(TypedDict):
    """Asks for the words that fit at an offset of the text with this number."""

    type: Literal["complete"]
    number: Count
    offset: Count


class Explain(TypedDict):
    """Asks for an explanation of the words at an offset of the text with this number."""

    type: Literal["explain"]
    number: Count
    offset: Count


class AskHandle(TypedDict):
    """Asks for the handle of the movement at an offset of the text with this number, and, if somebody `draws`, for the
    places of robots there."""

    type: Literal["handle"]
    number: Count
    offset: Count
    draws: bool


class AskPreview(TypedDict):
    """Asks for the paths of the text with this number. The page has those of the text with the `known` one."""

    type: Literal["preview"]
    number: Count
    known: NotRequired[Count]


class Write(TypedDict):
    """Save this text, which is an edit of a revision of the file, and play it."""

    type: Literal["write"]
    number: Count
    text: Text
    revision: Text


class PlaceRobots(TypedDict):
    """Robots were dragged to other starts on the page."""

    type: Literal["place"]
    start_poses: StartPoses


class ArrangeRobots(TypedDict):
    """Somebody chose a formation on the page: its distance in meters, and which way robots in a circle face."""

    type: Literal["arrange"]
    shape: Shape
    distance: Distance
    facing: Facing


class TuneMusic(TypedDict):
    """Somebody tapped another tempo on the page (`beat`, in beats per minute), or moved the song (`first_beat`, in
    seconds)."""

    type: Literal["tune"]
    key: Literal["beat", "first_beat"]
    value: SongTime


class BendMovement(TypedDict):
    """Somebody dragged the handle of the movement at an offset to a place on the floor. It snaps to round numbers
    unless it moves `freely`."""

    type: Literal["bend"]
    offset: Count
    place: Place
    freely: bool


class LengthenMovement(TypedDict):
    """Somebody made the movement at an offset longer, or shorter, by a number of round amounts."""

    type: Literal["lengthen"]
    offset: Count
    steps: Steps
    freely: bool


class DrawPath(TypedDict):
    """Somebody drew on the floor. If the robot comes to the offset, its words are written there; otherwise, as the line
    of the robot, which begins there, or continues from the beat `begin` on. Each line or arc ends on an nth of a beat
    (`parts`); with 0 parts, each takes a beat."""

    type: Literal["draw"]
    robot: Name
    offset: NotRequired[Count]
    points: DrawnPoints
    parts: Parts
    begin: NotRequired[Beat]


class PerformPart(TypedDict):
    """Somebody moved a robot by keys until a beat, counted from `begin` on. Their words become the robot's line from
    there on, on an nth of a beat."""

    type: Literal["perform"]
    robot: Name
    keys: Held
    end: Beat
    parts: Parts
    begin: NotRequired[Beat]


ProgramChange = PlaceRobots | ArrangeRobots | TuneMusic | BendMovement | LengthenMovement | DrawPath | PerformPart


class Change(TypedDict):
    """Asks for the edits of the text with this number that make a change. `first_beat` is in improv.toml, so the text
    stays. If somebody edits the program in an editor, that makes them, and nobody answers."""

    type: Literal["change"]
    number: Count
    change: ProgramChange


AskEditor = Analyze | Complete | Explain | AskHandle | AskPreview | Write | Change
"""The requests that a page may send about the program. An answer has the type of its request."""


class TextEdit(TypedDict):
    """Replaces the text between two offsets."""

    start: int
    end: int
    text: str


class TextFix(TypedDict):
    """A fix. Fixes of the same `kind` may be made together; one with an empty kind is made alone."""

    title: str
    kind: str
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


class ColorChange(TypedDict):
    """The numbers of the colors: the page keeps its `first` and `last` ones, with the `new` ones between them.

    A colored word has three: characters since the end of the last one, length, and kind.
    """

    first: int
    last: int
    new: Sequence[int]


class FirstProblems(TypedDict):
    """The first problems of a text, of `count`."""

    problems: Sequence[TextProblem]
    count: int


class Analyzed(FirstProblems):
    """`starts` are the starts of the robots of a text that has no errors."""

    type: Literal["analyze"]
    number: int
    colors: ColorChange
    starts: Mapping[str, StartPoseJson]


class RoomChecked(FirstProblems):
    """The problems of the text with this number, also those that take long to find."""

    type: Literal["check"]
    number: int


class OfferedWord(TypedDict):
    word: str
    about: str


class Completed(TypedDict):
    """The words that may replace the text between two offsets, best first."""

    type: Literal["complete"]
    number: int
    start: int
    end: int
    words: Sequence[OfferedWord]


class Explained(TypedDict):
    """The explanation of the words between two offsets, and their path as SVG."""

    type: Literal["explain"]
    number: int
    start: int
    end: int
    text: str
    picture: str


class ShownHandle(TypedDict):
    """The handle of the movement at an offset: its `text`, its robot, and its place on the floor, then that of the
    robot, in meters; null if there is none. The same words end at `others`, too. For somebody who draws, `pens` has the
    place of each robot as it comes to the offset."""

    type: Literal["handle"]
    number: int
    offset: int
    robot: str
    text: str
    place: Sequence[float] | None
    others: Sequence[Sequence[float]]
    pens: Mapping[str, Sequence[float]]


class PreviewedPath(TypedDict):
    """Starts at a pose (x, y, heading). Each stroke has the poses at its two ends, which a line or one arc joins. From
    stroke `certain` on, senses may decide otherwise. `look` is the robot's own."""

    start: Sequence[float]
    strokes: Sequence[Sequence[float]]
    certain: int
    look: RobotLook


class Preview(TypedDict):
    """The paths of robots in the text with this number, before it is saved. If one is missing, `problem` says why.
    Those of robots in `waits_for` come with another answer, once it is known what they sense. None is a path that the
    page has."""

    type: Literal["preview"]
    number: int
    robots: Mapping[str, PreviewedPath | None]
    problem: str
    waits_for: Sequence[str]


class Draft(TypedDict):
    """The text in an editor as it stands, before it is saved, and its paths. An empty text takes the last one back."""

    type: Literal["draft"]
    text: str
    paths: Preview


NO_DRAFT: Draft = {
    "type": "draft",
    "text": "",
    "paths": {"type": "preview", "number": 0, "robots": {}, "problem": "", "waits_for": []},
}


class Written(TypedDict):
    """The text with this number was saved as `revision`, or `problem` has the reason why not, in one line."""

    type: Literal["write"]
    number: int
    revision: str
    problem: str


class ChangeEdits(TypedDict):
    """The edits of the text with this number, in their order, or a `problem`: one line about why there are none."""

    type: Literal["change"]
    number: int
    edits: Sequence[TextEdit]
    problem: str


EditorAnswer = Analyzed | RoomChecked | Completed | Explained | ShownHandle | Preview | Written | ChangeEdits


class Answer(TypedDict):
    """An answer for one page, the one with this number."""

    type: Literal["answer"]
    page: int
    answer: EditorAnswer
