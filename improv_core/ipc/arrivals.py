"""The things that may arrive while a stage plays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from improv_core.protocol.commands import PageRequest, Pause, Stop
from improv_core.protocol.messages import Ping, Play, ToStage, after
from improv_core.protocol.output import Alarm, Edge, RawJoints, RawPoses
from improv_core.score.peer_clock import Anchor


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is not a valid message, or whose score can't be read: the reason, and whether it was a score."""

    problem: str
    is_score: bool = False


@dataclass(frozen=True, slots=True)
class Lost:
    """A score of this generation that builds on one that was never read. `after` is as in the protocol."""

    generation: int
    after: int | None = None


@dataclass(frozen=True, slots=True)
class First:
    """A message from the channel of stops, and its number."""

    message: Stop | Pause | Ping
    number: int


@dataclass(frozen=True, slots=True)
class DirectStop:
    """A stop that has come straight to the stage, with its identity. `confirm` is called once the output has all
    zeros."""

    stop: Stop
    confirm: Callable[[], None]


@dataclass(frozen=True, slots=True)
class End:
    """Standard input has ended or, because of a problem, can't be read; or a signal asks the stage to end."""

    problem: str = ""


Ordered = ToStage | Play | Unreadable | Lost
"""Arrivals from standard input, which the loop handles in their order."""
Arrival = Ordered | First | DirectStop | Edge | RawPoses | RawJoints | Alarm | Anchor | End


@dataclass(frozen=True, slots=True)
class OutputChannel:
    """The functions that an output may call, on any thread.

    `hear` gets edges, poses, alarms, and anchors, and the end if the output can receive nothing more. `ask` gets the
    requests of people who use the output's own tools. `warn` gets lines for people.
    """

    hear: Callable[[Arrival], None]
    ask: Callable[[PageRequest], None]
    warn: Callable[[str], None]


def request_in(arrival: Ordered) -> tuple[str, int | None]:
    """Return the type of a message that a stop may make void, and the number of messages that were sent on the channel
    of stops before it (None if nobody counts them). The type is empty for arrivals that no stop affects."""
    if isinstance(arrival, Play):
        return "load" if arrival.moves else "", after(arrival.load)
    if isinstance(arrival, Lost):
        return "load", arrival.after
    return ("", None) if isinstance(arrival, Unreadable) else (arrival["type"], after(arrival))
