"""The acts that a decision about stages can request, and the messages that follow. Standard library only.

Acts decide nothing; `Playback` does them, in their order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypedDict

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.commands import Editing, PageOpened
from improv_core.protocol.messages import Pressed, ToStage
from improv_core.score.score import OutsideClock
from improv_core.score.takeover import Takeover
from improv_core.session.state import PlayScore, SessionState, StageKey

News = Heard | PageOpened
"""The news for a listener: a message from a stage, its end, or an opened page."""


@dataclass(frozen=True, slots=True)
class Now:
    """Further facts for a decision: the monotonic time and Unix time, the count of stops at the request, which is
    `overtaken` if others have come since, the number of stops that were no pauses, the emergency stops that are on, and
    the number of presses of them that people know of."""

    at: float = 0.0
    wall: float = 0.0
    stops: int = 0
    overtaken: bool = False
    stopped: int = 0
    pressed: Pressed = field(default_factory=lambda: Pressed(type="pressed", topics=[], count=0))
    known: int = 0


@dataclass(frozen=True, slots=True)
class Send:
    """Send a message to a stage, `after` this many seconds; not if a stop has come since the count was `unless`."""

    to: StageKey
    message: ToStage
    after: float = 0.0
    unless: int | None = None


@dataclass(frozen=True, slots=True)
class SendScore:
    """Have stages play a score: the `whole` score, or the parts that they lack. With `entry`, they follow another
    stage; they take over `at` a monotonic time or later. `stops` are the presses of emergency stops that each stage may
    have received before somebody asked for the score. With `gathers`, beat 0 waits until all are ready. Robots of a
    stage that died `stood` there, and only stand now.

    If it is `asked` for, `Loaded` comes back, unless a stop has come since somebody asked: then it is not sent.
    """

    to: Sequence[StageKey]
    play: PlayScore
    entry: Takeover | None = None
    at: float | None = None
    stops: Mapping[StageKey, int] = field(default_factory=dict)
    asked: bool = False
    whole: bool = False
    gathers: bool = False
    stood: Takeover | None = None


@dataclass(frozen=True, slots=True)
class Announce:
    """Pass a message on to listeners, with whether it is from the leading stage, and for a request of a page on which
    somebody edits the program, the count of stops at that moment."""

    news: News | Editing
    leads: bool = True
    stops: int = 0


@dataclass(frozen=True, slots=True)
class Start:
    """Start a stage in place of one that has died. `Ready` or `Failed` comes back."""

    stage: StageKey


@dataclass(frozen=True, slots=True)
class HearClock:
    """Listen to this clock of music only. If nobody is in its session yet, that gets this tempo in beats per minute."""

    clock: OutsideClock | None
    tempo: float = 120.0


Act = Send | SendScore | Announce | Start | HearClock
StateAndActs = tuple[SessionState, list[Act]]


class Loaded(TypedDict):
    """A score that somebody asked for has been sent to the leading stages."""

    type: Literal["loaded"]
    play: PlayScore


class Failed(TypedDict):
    """A stage could not be started. The message has the reason."""

    type: Literal["failed"]
    message: str


Report = Heard | Loaded | Failed
"""The messages about a stage: its own, and the session's about its start, its scores, and its end."""


def warning(line: str) -> Announce:
    """Return a line for people, no matter which stage it is about."""
    return Announce({"type": "warning", "message": line})


def send(host: str, message: ToStage) -> Send:
    """Return a message to the stage of real robots on a host."""
    return Send(StageKey(host, "ros"), message)
