"""The commands that people may send: a row for each, with all properties in which they differ. Standard library only.

From these rows follow the requests of a page, ROS 2, and OSC, the messages that overtake others and make them void, the
ones that are kept for stages that start later, and the ones for the simulator beside real robots. A new command is a
message and a row here, and its rule in the player (`decide.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypedDict, TypeGuard, get_args

from improv_core.protocol.decoding import type_of
from improv_core.protocol.editing import AskEditor
from improv_core.protocol.fields import Beat, Factor, Name, Names
from improv_core.score.json_types import Monotonic, NotRequired


class _Timed(TypedDict, total=False):
    """`at` is the monotonic time at which a request takes effect; without it, that is when it arrives. For the parent,
    it is when somebody asked for it."""

    at: Monotonic


Automation = Literal["osc", "ros"]
"""The senders that are no person: OSC messages, and services of ROS 2."""
AUTOMATIONS: frozenset[Automation] = frozenset(get_args(Automation))


class _Asked(TypedDict, total=False):
    """`by` is the automation that sent this; without it, a person did."""

    by: Automation


class Added(_Timed, _Asked, total=False):
    """The fields that only Improv itself adds to a request.

    `direct` is the same in all copies of a stop, and each stage obeys it once. Nobody asked for a stop that
    is `unasked`: another stage has stopped by itself.
    """

    direct: str
    unasked: bool


class Stop(Added):
    """Stop every robot at once, on the channel of stops. `direct` identifies a stop that may also go straight to
    stages; a stage that gets it only from its parent answers `obeyed`."""

    type: Literal["stop"]


class Pause(_Timed):
    """Stop every robot, on the channel of stops; `resume` continues from there. Real robots that are yet to begin are
    stopped for good."""

    type: Literal["pause"]


class Resume(_Timed, _Asked):
    """Begin what is armed, continue after `pause`, or begin once robots are in their places; with `anyway`, wherever
    they stand. With a `beat`, seek it first. After a stop, automations may not be able to."""

    type: Literal["resume"]
    anyway: NotRequired[bool]
    beat: NotRequired[Beat]


class Seek(_Timed):
    """Play from another beat, or pause there if nothing plays. Simulated robots are put where the score has them; real
    ones stay. A beat that takes too long to compute is refused with a `warning`."""

    type: Literal["seek"]
    beat: Beat


class Speed(_Timed):
    """Multiply velocities and tempo by this factor, 0.1 to 4, for this score and later ones."""

    type: Literal["speed"]
    factor: Factor


class Silence(_Timed):
    """Have muted robots stand still or, if any are soloed, all others. Their parts keep counting. This replaces the
    previous `silence`, and is kept for later scores."""

    type: Literal["silence"]
    muted: Names
    soloed: Names


class Held(_Timed):
    """Somebody holds the deadman button of a gamepad at the page; repeated ten times a second."""

    type: Literal["held"]


class Released(_Timed):
    """The deadman button at the page was released."""

    type: Literal["released"]


class Cue(_Timed):
    """Somebody gives the cue: the sense `cue` is true for an instant, for every robot."""

    type: Literal["cue"]


class KeySense(_Timed):
    """Somebody holds the key of a sense (repeated ten times a second), or releases it; it counts as released 0.3 s
    after the last message."""

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


PageConduct = Stop | Pause | Resume | Seek | Speed | Silence | Held | Released | Cue | KeySense | Force
"""The controls that people in an editor or on a page have over playback."""
Conduct = PageConduct | OscSense
"""All controls over playback: the parent passes them on to its stages, all for the same moment."""


class Restart(_Timed, _Asked):
    """Play the latest score again from beat 0."""

    type: Literal["restart"]


class PageOpened(TypedDict):
    """Somebody opened a page, or closed one in a frame. `framed` is the number of pages in a frame now, as in VS Code,
    if that has changed."""

    type: Literal["page_opened"]
    framed: NotRequired[int]


class Editing(_Timed):
    """The page with this number asks for something about the program. A text that it asked for before a stop is saved,
    but not played; if the page's own stop has arrived first, `at` is 0."""

    type: Literal["editing"]
    page: int
    ask: AskEditor


PageRequest = Conduct | Restart | Editing
"""The requests that pages and others may send."""


Sender = Literal["page", "editor", "terminal", "ros", "osc"]


@dataclass(frozen=True, slots=True)
class Command:
    """A row. The docs list the senders, except programs that start a stage themselves."""

    message: type[Any]
    by: tuple[Sender, ...]
    stops: bool = False
    """It stops robots: it is obeyed wherever it arrives, ahead of all that waits."""
    at_once: bool = False
    """The stage whose node it reaches obeys it even before its parent does."""
    starts: bool = False
    """It may have robots begin or continue: one that an automation sends says so (`by`)."""
    kept: bool = False
    """It also holds for scores and stages that come later: only the latest counts."""
    as_sensed: bool = False
    """Robots sense it. The simulator beside real robots gets what they sensed instead of this."""
    overtakes: bool = False
    """It overtakes other commands that wait in a queue."""
    voids: frozenset[str] = frozenset()
    """Commands that must not be obeyed after it if they were sent before it."""
    about: Callable[[Any], str] = lambda message: ""
    """Returns the subject of a command. Of the waiting commands with one subject, only the latest counts."""

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
        voids=frozenset({"pause", "resume", "seek", "restart", "cue"}),
        # Each page waits until its own stop is confirmed, and a person's stop holds for more than those of automations.
        about=lambda stop: stop.get("by") or stop.get("direct", "").rpartition(" ")[0],
    ),
    Command(Pause, CONTROLS, stops=True, at_once=True),
    Command(Resume, CONTROLS, starts=True),
    Command(Restart, CONTROLS, starts=True),
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
    Command(Editing, ("page",), about=lambda editing: _about_editing(editing)),
)


def _about_editing(editing: Editing) -> str:
    """Return the subject of a request about a program: each page has a text of its own."""
    ask = editing["ask"]
    return f"{editing['page']} {ask['type']} {ask['change']['type'] if ask['type'] == 'change' else ''}"


COMMANDS: Mapping[str, Command] = {row.name: row for row in _ROWS}
"""The rows, by the type of their message."""

VOIDED_BY_STOP = COMMANDS["stop"].voids | {"load"}
"""The messages that must not be obeyed after a stop if they were sent before it."""


def is_stop(message: Mapping[str, Any]) -> TypeGuard[Stop | Pause]:
    row = COMMANDS.get(message["type"])
    return row is not None and row.stops


def is_muted(robot: str, muted: Collection[str], soloed: Collection[str]) -> bool:
    """Return whether a robot stands while others play: if any are soloed, all others; else muted ones."""
    return robot not in soloed if soloed else robot in muted


def starts(message: Mapping[str, Any]) -> bool:
    """Return whether a message is a command that may have robots begin or continue."""
    row = COMMANDS.get(message["type"])
    return row is not None and row.starts


def about(request: PageRequest) -> tuple[str, str]:
    """Return a request's type and what it is about. Of waiting requests with one subject, only the latest counts."""
    kind = request["type"]
    return kind, COMMANDS[kind].about(request)
