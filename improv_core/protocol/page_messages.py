"""The messages that only the page and its server exchange (docs/protocol.md). Standard library only.

`read` checks those that arrive at the server. The page has its types from here: `python -m tests.page_requests`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal, TypedDict, cast

from improv_core.protocol.commands import Added, PageConduct, Restart
from improv_core.protocol.decoding import by_type
from improv_core.protocol.editing import Answer, AskEditor, Draft, EditorAnswer, ProgramSource
from improv_core.protocol.fields import Beat, Count
from improv_core.protocol.host_messages import Link
from improv_core.protocol.messages import (
    Armed,
    Decided,
    Misplaced,
    Obeyed,
    PageMessage,
    ProgramMessage,
    Sensed,
    Stopped,
    TransportMessage,
)
from improv_core.protocol.robot_messages import FaultMessage, JointPositions, Measured, RobotLook, Vitals, WhyStill
from improv_core.score.json_types import fits, hints_of


class ServerTime(TypedDict):
    """The server's Unix time, for pages on machines whose clocks differ. It is the first message to a page."""

    type: Literal["time"]
    wall: float


class DrawnRobot(TypedDict):
    """A robot on the page: a disc of this radius in meters, and the joints that have moved so far."""

    radius: float
    joints: Sequence[str]


class DrawnRobots(TypedDict):
    """The robots on the page, whenever some appear or leave."""

    type: Literal["robots"]
    robots: Mapping[str, DrawnRobot]


class DrawnPoses(TypedDict):
    """The poses of all robots as x, y, z, and heading, in the order of `robots`, and the positions of each one's
    joints, in radians or meters, in the order of its `joints` there; up to 60 times a second.

    `at` is in seconds after beat 0. `placed` counts how often robots were put elsewhere without driving there.
    """

    type: Literal["poses"]
    at: float
    placed: int
    poses: Sequence[Sequence[float]]
    joints: Mapping[str, Sequence[float]]


DrawnTrail = TypedDict("DrawnTrail", {"from": int, "places": Sequence[Sequence[float]]})
"""Further places of a robot: seconds after beat 0, x, y, and heading, from which it moved along one arc to the next
place. `from` counts the places before them; with 0, the trail begins again.

In `measured` messages: seconds, beat, x, y, heading; its ideal x, y, heading; how far it was off in meters and radians;
how often its source was aligned; 1 if that was the simulator, otherwise 0; and 1 if it was pulled back to its path.
"""


class DrawnTrails(TypedDict):
    """The places of robots since beat 0 or the latest seek, each sent once. `placed` is as in `poses`: trails and poses
    with different numbers don't belong together."""

    type: Literal["trails"]
    placed: int
    robots: Mapping[str, DrawnTrail]


class DrawnMeasured(TypedDict):
    """The measured places of robots since beat 0, each sent once."""

    type: Literal["measured"]
    robots: Mapping[str, DrawnTrail]


class ShownBone(TypedDict):
    """A joint in a skeleton, as in `improv_core/score/body.py`: meters and radians."""

    joint: str
    carrier: int
    place: Sequence[float]
    turn: Sequence[float]
    axis: Sequence[float]
    way: Literal["turns", "slides", "stays"]
    rest: float
    follows: str | None
    ratio: float
    shift: float


class ShownRobot(RobotLook):
    """A robot of a score.

    `start_pose` is x, y, z, and heading; `near` is the reach of that sense in meters. `speeds` are
    what `forward` and `left` move it in a beat, in meters and radians. Its part `begins` and `ends` at a
    beat. `senses` are those that its part reads, with their sources as in a score.
    """

    dynamics: str
    speeds: Sequence[float]
    start_pose: Sequence[float]
    begins: float
    ends: float | None
    senses: Mapping[str, Mapping[str, Any]]
    near: float


class ShownDeadman(TypedDict):
    """The button of a gamepad that somebody has to hold while robots move."""

    button: int


class ShownMusic(TypedDict):
    """The song of a dance: its `file` as in improv.toml, "" if people choose one on the page; the seconds from its
    beginning to beat 0; and its volume, from 0 to 1."""

    file: str
    first_beat: float
    volume: float


class ShownScore(TypedDict):
    """A score as pages show it.

    `scenes` are the beats at which its scenes begin, from scene `scene` (from 0) on. `scene_names` are those of all
    scenes, "" for one without. `bar` is the number of beats in a bar, if the program sets it. `words` are those that
    move robots, each with its x, y, z, and yaw. `skeletons` are those of profiles. With `takes_start_poses`, each
    `change` that the page asks for can be written into the program.
    """

    type: Literal["score"]
    generation: int
    tempo: float
    scene: int
    scenes: Sequence[float]
    scene_names: Sequence[str]
    bar: int | None
    beats: float | None
    world: Mapping[str, Any] | None
    text: str
    offsets: Mapping[str, int]
    words: Mapping[str, Sequence[float]]
    robots: Mapping[str, ShownRobot]
    skeletons: Mapping[str, Sequence[ShownBone]]
    takes_start_poses: bool
    deadman: ShownDeadman | None
    music: ShownMusic | None


class BumpJson(TypedDict):
    at: float
    x: float
    y: float
    robots: Sequence[str]
    thing: str


class Bumps(TypedDict):
    """Robots have bumped into each other or into a `thing`, in words. Each bump is sent once; those of the `past` are
    from before the page was opened."""

    type: Literal["bumps"]
    past: bool
    bumps: Sequence[BumpJson]


class RobotWindow(TypedDict):
    """A robot's motion up to beat `until`: the ideal pose of its base at the beginning, and the moments of its base and
    of each body part that moves."""

    pose: Sequence[float] | None
    moments: Sequence[Sequence[Any]]
    body: Mapping[str, Sequence[Sequence[Any]]]
    until: float


class MeetingJson(TypedDict):
    """Two robots that come too near to each other at a beat, with their poses there, x, y, z, and heading; the shortest
    distance until they are apart again, in meters; and the number of their later meetings."""

    robots: Sequence[str]
    beat: float
    distance: float
    more: int
    poses: Sequence[Sequence[float]]


class HitJson(TypedDict):
    """A robot that comes too near to a thing in the world, such as `wall 1`, or `edge`, at a beat."""

    robot: str
    thing: str
    beat: float
    pose: Sequence[float]


MeetingsMessage = TypedDict(
    "MeetingsMessage",
    {
        "type": Literal["meetings"],
        "generation": int,
        "from": float,
        "to": float,
        "all": bool,
        "assumes": bool,
        "meetings": Sequence[MeetingJson],
        "hits": Sequence[HitJson],
    },
)
"""The meetings in a score between two beats, the first hundred of each kind: sent after a score, and again after it has
taken over: then robots whose simulated senses decide are left out. If it is `all`, nothing else comes after that; if it
`assumes`, senses may change them."""


class Press(TypedDict):
    """A press of *Stop* on this page, which counts them, at its place among the page's other requests."""

    type: Literal["press"]
    number: Count


AskWindow = TypedDict("AskWindow", {"type": Literal["window"], "generation": Beat, "from": Beat, "to": Beat})
Window = TypedDict(
    "Window",
    {"type": Literal["window"], "generation": int, "from": float, "to": float, "robots": Mapping[str, RobotWindow]},
)
"""The answer to `AskWindow`: the motion of robots between two beats, and the words that play, if no sense changes."""

ToPage = (
    DrawnRobots | ServerTime | DrawnPoses | DrawnTrails | DrawnMeasured | TransportMessage | Stopped | ProgramMessage
    | ShownScore | Bumps | Window | MeetingsMessage | Misplaced | Armed | Sensed | Decided | FaultMessage | Vitals
    | WhyStill | Link | JointPositions | ProgramSource | Draft | EditorAnswer
)  # fmt: skip
FromPage = Press | PageConduct | Restart | AskWindow | AskEditor
ForPages = (
    ProgramMessage | ProgramSource | Draft | Answer | TransportMessage | Stopped | Sensed | Decided | Measured
    | JointPositions | Misplaced | Armed | FaultMessage | Vitals | Link | WhyStill | Obeyed
)  # fmt: skip
"""The messages of the session and of stages to the server of the pages: in an envelope, if they come from another
process."""


def for_pages(message: ForPages) -> PageMessage:
    """Return a message in its envelope."""
    return {"type": "page", "message": message}


def fields_of(message: Any) -> set[str]:
    """Return the fields of a request that a page may send."""
    return hints_of(message).keys() - hints_of(Added).keys()


def read(text: str) -> FromPage | None:
    """Return the request in a message, without values that only Improv itself may add, or None."""
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return None
    kind = message.get("type") if isinstance(message, dict) else None
    expected = _requests().get(kind) if isinstance(kind, str) else None
    if expected is None:
        return None
    request = {name: value for name, value in message.items() if name in fields_of(expected)}
    return cast(FromPage, request) if fits(request, expected) else None


@lru_cache
def _requests() -> Mapping[str, Any]:
    return by_type(FromPage)
