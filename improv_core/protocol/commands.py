"""What people may ask for: a row for each command, with all that depends on which one it is. Standard library only.

From these rows follow what a page, ROS 2, and OSC may send, which messages overtake others and make them void, which
are kept for stages that start later, and what the simulator beside real robots is told. A new command is a message and
a row here, and what the loop does about it (`loop.OBEYED`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypedDict, TypeGuard, get_args

from improv_core.protocol.decoding import type_of
from improv_core.protocol.editing import AskEditor
from improv_core.protocol.fields import Beat, Distance, Facing, Factor, Name, Names, Shape, SongTime, StartPoses


class _Timed(TypedDict, total=False):
    """`at` is the monotonic time at which a request takes effect; without it, that is when it arrives."""

    at: float


Automation = Literal["osc", "ros"]
"""What asks for something without a person: OSC messages, and services of ROS 2."""
AUTOMATIONS: frozenset[Automation] = frozenset(get_args(Automation))


class _Asked(TypedDict, total=False):
    """`by` is what asked for this; without it, a person did."""

    by: Automation


class Marked(TypedDict, total=False):
    """`mark` is how a page recognizes its stop once that has been obeyed. It goes to the stages that have to say so."""

    mark: str


class Stop(_Timed, Marked, _Asked):
    type: Literal["stop"]


class Pause(_Timed):
    type: Literal["pause"]


class Resume(_Timed, _Asked):
    type: Literal["resume"]


class Anyway(_Timed):
    """Continue, or begin, even if robots are not in their places."""

    type: Literal["anyway"]


class Seek(_Timed):
    type: Literal["seek"]
    beat: Beat


class Speed(_Timed):
    type: Literal["speed"]
    factor: Factor


class Silence(_Timed):
    type: Literal["silence"]
    muted: Names
    soloed: Names


class Held(_Timed):
    """Somebody holds the deadman button of a gamepad at the page; sent repeatedly."""

    type: Literal["held"]


class Released(_Timed):
    """The deadman button at the page was released."""

    type: Literal["released"]


class Cue(_Timed):
    """Somebody gives the cue: the sense `cue` is true for an instant."""

    type: Literal["cue"]


class KeySense(_Timed):
    """Somebody holds the key of a sense, which is sent repeatedly, or releases it."""

    type: Literal["key"]
    key: Name
    held: bool


class Force(_Timed):
    """Make a simulated robot sense this, whatever is around it. Null ends that."""

    type: Literal["force"]
    robot: Name
    sense: Name
    value: bool | None


class OscSense(_Timed):
    """An OSC message makes the senses of a robot that are declared with this name true or false."""

    type: Literal["osc_sense"]
    name: Name
    robot: Name
    value: bool


PageConduct = Stop | Pause | Resume | Anyway | Seek | Speed | Silence | Held | Released | Cue | KeySense | Force
"""What people in an editor or on a page may do to what plays."""
Conduct = PageConduct | OscSense
"""What may be done to what plays."""


class _Restart(TypedDict):
    type: Literal["restart"]


class Restart(_Restart, _Asked):
    """What was played last should play again from beat 0."""


class PlaceRobots(TypedDict):
    """Robots were dragged to other starts on the page."""

    type: Literal["place"]
    start_poses: StartPoses


class Form(TypedDict):
    """Somebody chose a formation on the page: its distance in meters, and which way robots in a circle face."""

    type: Literal["form"]
    shape: Shape
    distance: Distance
    facing: Facing


class Tune(TypedDict):
    """Somebody tapped another tempo on the page (`beat`, in beats per minute), or moved the song (`first_beat`, in
    seconds)."""

    type: Literal["tune"]
    key: Literal["beat", "first_beat"]
    value: SongTime


class Framed(TypedDict, total=False):
    """`framed` is how many pages are in a frame now, as in VS Code, if one of these was opened or closed."""

    framed: int


class Watched(Framed):
    """Somebody opened a page, or closed one in a frame."""

    type: Literal["watched"]


class _Editing(TypedDict):
    type: Literal["editing"]
    page: int
    ask: AskEditor


class Editing(_Editing, total=False):
    """The page with this number asks for something while somebody edits the program on it.

    If it is `overtaken`, a stop that the page sent after it has arrived before it: a text is saved, but not played.
    """

    overtaken: bool


PageRequest = Conduct | Restart | PlaceRobots | Form | Tune | Editing
"""What somebody may request on the page, or from elsewhere."""


Sender = Literal["page", "editor", "terminal", "ros", "osc"]


@dataclass(frozen=True, slots=True)
class Command:
    """A row. The docs say in words who sends it, apart from programs that start a stage themselves."""

    message: type[Any]
    by: tuple[Sender, ...]
    stops: bool = False
    """It stops robots: obeyed wherever it arrives, ahead of all that waits."""
    at_once: bool = False
    """The stage whose node it reaches obeys it even before its parent does."""
    to_stages: bool = True
    """The parent passes it on to its stages, all for the same moment; otherwise the parent does it."""
    kept: bool = False
    """It also holds for scores and stages that come later: only the latest counts."""
    as_sensed: bool = False
    """Robots sense it. The simulator beside real robots is told what they sensed, and not this."""
    overtakes: bool = False
    """It overtakes other commands that wait in a queue."""
    voids: frozenset[str] = frozenset()
    """Commands that were sent before it, and must not be obeyed after it."""
    about: Callable[[Any], str] = lambda message: ""
    """Of waiting commands that are about the same thing, only the latest counts."""

    @property
    def name(self) -> str:
        return type_of(self.message)


CONTROLS: tuple[Sender, ...] = ("page", "editor", "ros", "osc")

_ROWS = (
    Command(
        Stop,
        (*CONTROLS, "terminal"),
        stops=True,
        at_once=True,
        overtakes=True,
        voids=frozenset({"pause", "resume", "anyway", "seek", "restart", "cue"}),
        # Each page waits until its own is confirmed, and a person's stop holds for more than those of automations.
        about=lambda stop: stop.get("by") or stop.get("mark", "").rpartition(" ")[0],
    ),
    Command(Pause, CONTROLS, stops=True, at_once=True),
    Command(Resume, CONTROLS),
    Command(Anyway, ("page", "editor")),
    Command(Restart, CONTROLS, to_stages=False),
    Command(Seek, ("page", "editor", "osc")),
    Command(Speed, CONTROLS, at_once=True, kept=True),
    Command(Silence, ("page", "editor"), kept=True),
    Command(Held, ("page",)),
    Command(Released, ("page",), overtakes=True, voids=frozenset({"held"})),
    Command(Cue, ("page", "editor", "terminal", "osc"), as_sensed=True),
    Command(KeySense, ("page", "editor"), as_sensed=True, about=lambda sense: sense["key"]),
    Command(Force, ("page",), as_sensed=True, about=lambda force: f"{force['robot']} {force['sense']}"),
    Command(
        OscSense, ("osc",), as_sensed=True, about=lambda sense: f"{sense['robot']} {sense['name']} {sense['value']}"
    ),
    Command(PlaceRobots, ("page",), to_stages=False),
    Command(Form, ("page",), to_stages=False),
    Command(Tune, ("page",), to_stages=False, about=lambda tune: str(tune["key"])),
    Command(
        Editing,
        ("page",),
        to_stages=False,
        about=lambda editing: f"{editing['page']} {editing['ask']['type']}",  # each page has a text of its own
    ),
)

COMMANDS: Mapping[str, Command] = {row.name: row for row in _ROWS}
"""The rows, by the type of their message."""

VOID = COMMANDS["stop"].voids | {"load"}
"""What was sent before a stop, and must not be obeyed after it."""


def is_stop(message: Mapping[str, Any]) -> TypeGuard[Stop | Pause]:
    """Whether a message is a command that stops robots."""
    row = COMMANDS.get(message["type"])
    return row is not None and row.stops


def about(request: PageRequest) -> tuple[str, str]:
    """What a request is about, beginning with its type. If several wait, only the latest counts."""
    kind = request["type"]
    return kind, COMMANDS[kind].about(request)
