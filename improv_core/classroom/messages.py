"""The messages between the children's process, the desk, and the teacher's page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, TypedDict, cast

from improv_core.classroom.roster import MAX_SHOWN
from improv_core.protocol.decoding import ProtocolError, read_as
from improv_core.score.json_types import Long

Chosen = Annotated[Sequence[int], Long(1, MAX_SHOWN)]


class Joined(TypedDict):
    """A child joined, perhaps again, or opened or closed its page. It is `here` while its page is open."""

    type: Literal["joined"]
    number: int
    name: str
    here: bool


class Handed(TypedDict):
    """A child has sent its `count`-th dance, at this second since 1970."""

    type: Literal["handed"]
    number: int
    count: int
    sent: float
    text: str


class DanceRead(TypedDict):
    """A dance was read: whether it can be played, a line about it, and the picture of its paths as SVG, or ""."""

    type: Literal["looked"]
    number: int
    count: int
    ok: bool
    line: str
    picture: str


class Serving(TypedDict):
    """The children's process serves its website at this address, for those who know the code; or it can't because of a
    `problem`, in one line."""

    type: Literal["serving"]
    address: str
    code: str
    problem: str


class Keeping(TypedDict):
    """The folder in which dances are kept, or the reason why the latest ones are not, in one line."""

    type: Literal["keeping"]
    folder: str
    problem: str


class DanceShown(TypedDict):
    """A child's `count`-th dance, which it sent at this second since 1970, and its check: `ok` is None until it is
    read."""

    count: int
    sent: float
    ok: bool | None
    line: str
    picture: str


class ChildShown(TypedDict):
    """A child that is `here` or was, its latest dance, and its latest one that can be played: perhaps the same."""

    type: Literal["child"]
    number: int
    name: str
    here: bool
    latest: DanceShown | None
    good: DanceShown | None


class SentOut(TypedDict):
    """A child is no longer in the class: the teacher has removed it, or it has left and has sent nothing."""

    type: Literal["gone"]
    number: int


class RealRobots(TypedDict):
    """The real robots that may perform children's dances."""

    type: Literal["robots"]
    names: Sequence[str]


class NowPlaying(TypedDict):
    """The dance that plays, or the reason why none does."""

    type: Literal["playing"]
    line: str


class PlayThese(TypedDict):
    """Play the dances of these children together, in the simulator."""

    type: Literal["play"]
    numbers: Chosen


class Remove(TypedDict):
    """Remove children from the class."""

    type: Literal["remove"]
    numbers: Chosen


class Perform(TypedDict):
    """Play a child's `count`-th dance, which the teacher has looked at, on this real robot, or in the simulator if
    `robot` is empty."""

    type: Literal["perform"]
    number: int
    count: int
    robot: str


FromChildren = Joined | SentOut | Handed | DanceRead | Keeping
FromDesk = ChildShown | SentOut | NowPlaying | RealRobots | Keeping
Command = PlayThese | Remove | Perform


def read(text: str) -> Command | None:
    """Read a command of the teacher's page; None if it isn't valid."""
    try:
        return cast(Command, read_as(text.encode(), Command))
    except ProtocolError:
        return None
