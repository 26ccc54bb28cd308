"""What crosses from and to the processes of the bridge, as lines of JSON. Times are Unix time in `stamp`, else
monotonic; headings are in radians."""

from __future__ import annotations

from typing import Literal, TypedDict


class Ready(TypedDict):
    """The bridge has made all its robots' topics."""

    type: Literal["ready"]


class Told(TypedDict):
    """A robot has heard a velocity."""

    type: Literal["told"]
    robot: str
    linear: float
    angular: float
    at: float


class Wheels(TypedDict):
    """What a robot's encoders have counted."""

    type: Literal["wheels"]
    robot: str
    x: float
    y: float
    heading: float
    linear: float
    angular: float
    stamp: float


class Seen(TypedDict):
    """Where a camera says that a robot was at `stamp`."""

    type: Literal["seen"]
    robot: str
    x: float
    y: float
    heading: float
    stamp: float


class Battery(TypedDict):
    """How full a robot's battery is, from 0 to 1."""

    type: Literal["battery"]
    robot: str
    share: float
    stamp: float


class There(TypedDict):
    """A robot's node should be there, or not."""

    type: Literal["there"]
    robot: str
    there: bool


FromBridge = Ready | Told
ToBridge = Wheels | Seen | Battery | There
