"""The acts that a decision about stages can request, and the messages that follow. Standard library only.

Acts decide nothing; `Playback` does them, in their order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.commands import Editing, Watched
from improv_core.protocol.messages import ToStage
from improv_core.score.score import OutsideClock
from improv_core.score.takeover import Takeover
from improv_core.session.start import SinkName
from improv_core.session.state import PlayScore

News = Heard | Watched
"""The news for a listener: a message from a stage, its end, or an opened page."""


@dataclass(frozen=True, slots=True)
class Send:
    """Send a message to a stage, `after` this many seconds; not if a stop has come since the count was `unless`."""

    name: SinkName
    message: ToStage
    after: float = 0.0
    unless: int | None = None


@dataclass(frozen=True, slots=True)
class SendScore:
    """Have a stage play a score: the `whole` score, or the parts that it lacks. With `entry`, it follows another stage.

    If it is `asked` for, `Loaded` comes back, unless a stop has come since somebody asked: then it is not sent.
    """

    name: SinkName
    play: PlayScore
    entry: Takeover | None = None
    asked: bool = False
    whole: bool = False


@dataclass(frozen=True, slots=True)
class Announce:
    """Pass a message on to listeners, with whether it is from the leading stage, and for a request of a page on which
    somebody edits the program, the count of stops at that moment."""

    news: News | Editing
    leads: bool = True
    stops: int = 0


@dataclass(frozen=True, slots=True)
class StartAgain:
    """Start a stage in place of one that has died. `Ready` or `Failed` comes back."""

    name: SinkName


@dataclass(frozen=True, slots=True)
class HearClock:
    """Listen to this clock of music, and no longer to another one. If nobody is in its session yet, that gets this
    tempo, in beats per minute."""

    clock: OutsideClock | None
    tempo: float = 120.0


Act = Send | SendScore | Announce | StartAgain | HearClock


class Loaded(TypedDict):
    """A score that somebody asked for has been sent to the leading stage."""

    type: Literal["loaded"]
    play: PlayScore


class Failed(TypedDict):
    """A stage could not be started. The message has the reason."""

    type: Literal["failed"]
    message: str
