"""Messages from and to the processes of the bridge, as lines of JSON. `stamp` is Unix time, all other times are
monotonic; headings are in radians."""

from __future__ import annotations

from typing import Literal, TypedDict


class Ready(TypedDict):
    """The bridge's message that it has made all its robots' topics."""

    type: Literal["ready"]


class Told(TypedDict):
    """A velocity that a robot has heard."""

    type: Literal["told"]
    robot: str
    linear: float
    angular: float
    at: float


class Wheels(TypedDict):
    """A robot's pose and speeds by its encoders."""

    type: Literal["wheels"]
    robot: str
    x: float
    y: float
    heading: float
    linear: float
    angular: float
    stamp: float


class Seen(TypedDict):
    """A robot's pose at `stamp`, as a camera reports it."""

    type: Literal["seen"]
    robot: str
    x: float
    y: float
    heading: float
    stamp: float


class Battery(TypedDict):
    """A robot's battery level, from 0 to 1."""

    type: Literal["battery"]
    robot: str
    share: float
    stamp: float


class There(TypedDict):
    """A request to make or remove a robot's node."""

    type: Literal["there"]
    robot: str
    there: bool


FromBridge = Ready | Told
ToBridge = Wheels | Seen | Battery | There
