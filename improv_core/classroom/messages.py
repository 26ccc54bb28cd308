"""The messages between the children's process, the desk, and the teacher's page."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Literal, TypedDict

from improv_core.classroom.roster import MOST_CHILDREN


class Joined(TypedDict):
    """A child has come."""

    type: Literal["joined"]
    number: int
    name: str


class Left(TypedDict):
    """A child has gone: its browser has joined again."""

    type: Literal["left"]
    number: int


class Handed(TypedDict):
    """A child has sent its `count`-th dance."""

    type: Literal["handed"]
    number: int
    count: int
    text: str


class DanceRead(TypedDict):
    """A dance was looked at: whether it can be played, a line about it, and the picture of its paths as SVG, or ""."""

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


class SendOut(TypedDict):
    """From now on, these children can't send anything."""

    numbers: list[int]


class ChildShown(TypedDict):
    """A child, how many dances it has sent (0: none yet), and what is known about the latest."""

    type: Literal["child"]
    number: int
    name: str
    count: int
    ok: bool
    line: str
    picture: str


class SentOut(TypedDict):
    """A child was sent out."""

    type: Literal["gone"]
    number: int


class RealRobots(TypedDict):
    """The real robots that may dance what a child has sent."""

    type: Literal["robots"]
    names: Sequence[str]


class NowPlaying(TypedDict):
    """What plays, or why nothing does."""

    type: Literal["playing"]
    line: str


class PlayThese(TypedDict):
    """Play the dances of these children together, in the simulator."""

    type: Literal["play"]
    numbers: list[int]


class Remove(TypedDict):
    """Send children out."""

    type: Literal["remove"]
    numbers: list[int]


class Perform(TypedDict):
    """Have a real robot perform the dance of a child that was looked at: the one that it has sent as its `count`-th."""

    type: Literal["perform"]
    number: int
    count: int
    robot: str


FromChildren = Joined | Left | Handed | DanceRead
FromDesk = ChildShown | SentOut | NowPlaying | RealRobots
Command = PlayThese | Remove | Perform


def read(text: str) -> Command | None:
    """A command of the teacher's page; None if it is none."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict):
        return None
    match found:
        case {"type": "remove", "numbers": [*numbers]} if _are_of_children(numbers):
            return {"type": "remove", "numbers": numbers}
        case {"type": "perform", "number": int(number), "count": int(count), "robot": str(robot)}:
            return {"type": "perform", "number": number, "count": count, "robot": robot}
        case {"type": "play", "numbers": [*numbers]} if _are_of_children(numbers):
            return {"type": "play", "numbers": numbers}
    return None


def _are_of_children(numbers: Sequence[object]) -> bool:
    return 0 < len(numbers) <= MOST_CHILDREN and all(isinstance(each, int) for each in numbers)
