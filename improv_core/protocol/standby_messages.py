"""The messages between a stage and its standby (docs/protocol.md). Standard library only."""

from __future__ import annotations

from typing import Literal, TypedDict

from improv_core.protocol.json_lines import Alive


class Publish(TypedDict):
    """The stage has a publisher: `kind` is the type of its messages, and it may belong to its second node. For a
    velocity controller, `joints` is the number of its joints; otherwise 0."""

    type: Literal["publish"]
    topic: str
    kind: str
    second: bool
    joints: int


class Withdraw(TypedDict):
    """The stage no longer has a publisher."""

    type: Literal["withdraw"]
    topic: str
    kind: str


class RobotMoves(TypedDict):
    """A robot is about to be sent velocities in a frame; `patience` as in `Pulse`."""

    type: Literal["moves"]
    topic: str
    frame: str
    patience: float


class Pulse(TypedDict):
    """The stage lives; if nothing more comes within `patience` seconds, it hangs. Sent ten times a second while robots
    move. Its stamps are `ahead` of the machine's time by this many nanoseconds, as in a simulation."""

    type: Literal["pulse"]
    patience: float
    ahead: int


class RobotsStand(TypedDict):
    """All robots have been sent zeros. Those that moved may not have received theirs, until `moves` or `confirmed`. If
    the stage fails before that, the standby repeats them for 30 s at most."""

    type: Literal["stands"]


class ZeroPending(TypedDict):
    """The robot on a topic may not have received its zero; sent for robots that `stands` is not about."""

    type: Literal["pending"]
    topic: str
    frame: str


class ZeroConfirmed(TypedDict):
    """The robot on a topic has received its zero, or the stage has given up sending it."""

    type: Literal["confirmed"]
    topic: str


class EndStandby(TypedDict):
    """The stage ends, and its robots stand."""

    type: Literal["end"]


ToStandby = Publish | Withdraw | RobotMoves | Pulse | RobotsStand | ZeroPending | ZeroConfirmed | EndStandby
"""From the stage to its standby, over a pipe."""


class ListenerFound(TypedDict):
    """A publisher of the standby's has found a listener."""

    type: Literal["found"]
    topic: str
    kind: str


FromStandby = Alive | ListenerFound
