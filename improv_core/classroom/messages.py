"""What the teacher's page and its server tell each other."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Literal, TypedDict

from improv_core.classroom.roster import MOST_CHILDREN


class ChildShown(TypedDict):
    """A child, the latest dance that it sent, how many it has sent (0: none yet), and what is known about it."""

    type: Literal["child"]
    number: int
    name: str
    count: int
    ok: bool
    line: str
    picture: str
    text: str


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
    """Send a child out."""

    type: Literal["remove"]
    number: int


class Perform(TypedDict):
    """Have a real robot perform the dance of a child that was looked at: the one that it has sent as its `count`-th."""

    type: Literal["perform"]
    number: int
    count: int
    robot: str


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
        case {"type": "remove", "number": int(number)}:
            return {"type": "remove", "number": number}
        case {"type": "perform", "number": int(number), "count": int(count), "robot": str(robot)}:
            return {"type": "perform", "number": number, "count": count, "robot": robot}
        case {"type": "play", "numbers": [*numbers]} if 0 < len(numbers) <= MOST_CHILDREN:
            return {"type": "play", "numbers": numbers} if all(isinstance(each, int) for each in numbers) else None
    return None
