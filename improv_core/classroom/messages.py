"""What the teacher's page and its server tell each other."""

from __future__ import annotations

import json
from typing import Literal, TypedDict

from improv_core.classroom.room import MOST_CHILDREN


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


FromDesk = ChildShown | SentOut | NowPlaying
Command = PlayThese | Remove


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
        case {"type": "play", "numbers": [*numbers]} if 0 < len(numbers) <= MOST_CHILDREN:
            return {"type": "play", "numbers": numbers} if all(isinstance(each, int) for each in numbers) else None
    return None
