"""The messages between the children's process, the desk, and the teacher's page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, TypedDict, cast

from improv_core.classroom.roster import MOST_CHILDREN
from improv_core.protocol.decoding import ProtocolError, read_as
from improv_core.score.fits import Long

Chosen = Annotated[Sequence[int], Long(1, MOST_CHILDREN)]


class Joined(TypedDict):
    """A child has joined."""

    type: Literal["joined"]
    number: int
    name: str


class Handed(TypedDict):
    """A child has sent its `count`-th dance."""

    type: Literal["handed"]
    number: int
    count: int
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
    """The children's process serves its website at this address, or can't because of a `problem`, in one line."""

    type: Literal["serving"]
    address: str
    problem: str


class ChildShown(TypedDict):
    """A child, the number of dances it has sent, and the check of the latest one."""

    type: Literal["child"]
    number: int
    name: str
    count: int
    ok: bool
    line: str
    picture: str


class SentOut(TypedDict):
    """A child is no longer in the class: its browser has joined again, or the teacher has removed it."""

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
    """Have a real robot perform the dance that a child has sent as its `count`-th and the teacher has looked at."""

    type: Literal["perform"]
    number: int
    count: int
    robot: str


FromChildren = Joined | SentOut | Handed | DanceRead
FromDesk = ChildShown | SentOut | NowPlaying | RealRobots
Command = PlayThese | Remove | Perform


def read(text: str) -> Command | None:
    """Read a command of the teacher's page; None if it isn't valid."""
    try:
        return cast(Command, read_as(text.encode(), Command))
    except ProtocolError:
        return None
