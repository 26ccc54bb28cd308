"""What a decision about stages can ask for, and what comes back. Standard library only.

Acts decide nothing; `Playback` does them, in their order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.commands import Editing, Form, PlaceRobots, Tune, Watched
from improv_core.protocol.messages import Takeover, ToStage
from improv_core.score.score import OutsideClock
from improv_core.session.start import SinkName
from improv_core.session.state import PlayScore

News = Heard | PlaceRobots | Form | Tune | Watched
"""What a listener gets: a message from a stage, its end, that a page was opened, or start poses that it asks for."""


@dataclass(frozen=True, slots=True)
class Send:
    """Send a message to a stage, `after` this many seconds; not if a stop has come since the count was `unless`."""

    name: SinkName
    message: ToStage
    after: float = 0.0
    unless: int | None = None


@dataclass(frozen=True, slots=True)
class SendScore:
    """Have a stage play a score: the `whole` score, or what it lacks of it. With `entry`, it follows another stage.

    If it is `asked` for, `Loaded` comes back, unless a stop has come since somebody asked: then it is not sent.
    """

    name: SinkName
    play: PlayScore
    entry: Takeover | None = None
    asked: bool = False
    whole: bool = False


@dataclass(frozen=True, slots=True)
class Announce:
    """Tell listeners, and whether it is from the stage that leads."""

    news: News
    leads: bool = True


@dataclass(frozen=True, slots=True)
class StartAgain:
    """Start a stage in place of one that has died. `Ready` or `Failed` comes back."""

    name: SinkName


@dataclass(frozen=True, slots=True)
class PassOn:
    """Pass on what a page asks for while somebody edits the program, and the count of stops at that moment."""

    editing: Editing
    stops: int


@dataclass(frozen=True, slots=True)
class HearClock:
    """Listen to this clock of music, and no longer to another one. A session that we are the first in has this tempo,
    in beats per minute."""

    clock: OutsideClock | None
    tempo: float = 120.0


Act = Send | SendScore | Announce | StartAgain | PassOn | HearClock


class Loaded(TypedDict):
    """A score that was asked for has been sent to the stage that leads."""

    type: Literal["loaded"]
    play: PlayScore


class Failed(TypedDict):
    """A stage could not be started. The message says why."""

    type: Literal["failed"]
    message: str
