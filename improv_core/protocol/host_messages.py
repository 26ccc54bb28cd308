"""The messages of a stage on another machine about its link to the parent. Standard library only."""

from __future__ import annotations

from typing import Literal, TypedDict


class ParentLost(TypedDict):
    """The stage of a host has stopped its robots, since it has received nothing from its parent for this long."""

    type: Literal["deserted"]
    seconds: float


class Link(TypedDict):
    """The quality of the link to a host, once a second, in seconds: its clock is ahead of ours by `offset`, known to
    `error`; a message and its answer take `round_trip`, and nearly every message arrives within `lag`."""

    type: Literal["link"]
    host: str
    offset: float
    error: float
    round_trip: float
    lag: float
