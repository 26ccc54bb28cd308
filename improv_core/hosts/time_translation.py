"""Translates times between two machines, and checks the messages of a stage over there.

No other module knows that its clock is another one. A stage there gets its own monotonic and Unix times, and its parent
here gets times of this machine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from improv_core.hosts.clock_offset import Clocks
from improv_core.protocol.commands import COMMANDS

SECOND = 1_000_000_000
"""Nanoseconds."""


@dataclass(frozen=True, slots=True)
class TimeTranslation:
    """The monotonic clock there, and the lead of Unix time over monotonic time on both sides: `wall` here, `wall_there`
    there, in nanoseconds. `asleep` are the seconds by which the machine there has slept longer."""

    clocks: Clocks
    wall: int
    wall_there: int
    asleep: float

    def at_there(self, here: float) -> float:
        """Return the remote machine's monotonic time, in seconds."""
        return self.clocks.there(here)

    def at_here(self, there: float) -> float:
        """Return the monotonic time here, in seconds."""
        return self.clocks.here(there)

    def unix_there(self, here: float) -> float:
        """Return the Unix time there at a Unix time here, in seconds."""
        return self.clocks.there(here - self.wall / SECOND) + self.wall_there / SECOND

    def unix_here(self, there: float) -> float:
        """Return the Unix time here at a Unix time there, in seconds."""
        return self.clocks.here(there - self.wall_there / SECOND) + self.wall / SECOND

    def nanoseconds_here(self, there: int) -> int:
        """Return the same in nanoseconds, of which floats of seconds would lose 200."""
        monotonic = there - self.wall_there
        ahead = self.clocks.here(monotonic / SECOND) - monotonic / SECOND
        return monotonic + round(ahead * SECOND) + self.wall

    def nanoseconds_there(self, here: int) -> int:
        monotonic = here - self.wall
        ahead = self.clocks.there(monotonic / SECOND) - monotonic / SECOND
        return monotonic + round(ahead * SECOND) + self.wall_there


def to_there(message: Mapping[str, Any], translation: TimeTranslation) -> dict[str, Any]:
    """Return a checked message to the stage, with the times of its machine."""
    crossed = _with(message, {"at": translation.at_there})
    if crossed["type"] == "load":
        crossed = _with(crossed, {"asleep": lambda slept: slept + translation.asleep})
        for name, change in _LOADED.items():
            if name in crossed:
                crossed[name] = change(crossed[name], translation)
    elif crossed["type"] == "armed":
        _set_begins(crossed, translation.unix_there)
    else:
        crossed = _with(crossed, {"wall": translation.nanoseconds_there})
        if "robots" in crossed and isinstance(crossed["robots"], Mapping):
            crossed["robots"] = _each(
                crossed["robots"], {"wall": translation.nanoseconds_there, "at": translation.at_there}
            )
    return crossed


def to_here(message: Mapping[str, Any], translation: TimeTranslation) -> dict[str, Any] | None:
    """Return a message from the stage, with the times of this machine; None for messages that no stage of real robots
    sends.

    Whoever controls the machine there may send anything. So it can't open a page here, or request things that only a
    page may, such as a change of the program.
    """
    kind = message["type"]
    if kind == "request":
        row = COMMANDS.get(message["command"]["type"])
        command = _with(message["command"], {"at": translation.at_here})
        return {**message, "command": command} if row and "ros" in row.by else None
    if kind == "ready":
        return {name: message[name] for name in ("type", "protocol", "sink", "real")}
    if kind == "link":
        return None
    crossed = _with(message, {"monotonic": translation.at_here})
    if kind == "transport":
        return _with(crossed, {"wall": translation.unix_here})
    if kind == "armed":
        _set_begins(crossed, translation.unix_here)
    elif kind == "measured":
        crossed["robots"] = _each(crossed["robots"], {"wall": translation.nanoseconds_here})
    elif kind == "seen":
        crossed["robots"] = _each(crossed["robots"], {"at": translation.at_here})
    return _with(crossed, {"wall": translation.nanoseconds_here})


def _with(message: Mapping[str, Any], changes: Mapping[str, Callable[[Any], Any]]) -> dict[str, Any]:
    return {name: changes[name](value) if name in changes else value for name, value in message.items()}


def _each(robots: Mapping[str, Any], changes: Mapping[str, Callable[[Any], Any]]) -> dict[str, Any]:
    return {robot: _with(told, changes) for robot, told in robots.items()}


def _set_begins(message: dict[str, Any], change: Callable[[float], float]) -> None:
    if message["begins"] is not None:
        message["begins"] = change(message["begins"])


_LOADED: Mapping[str, Callable[[Any, TimeTranslation], Any]] = {
    "entry": lambda entry, translation: _with(entry, {"monotonic": translation.at_there}),
    "arming": lambda arming, translation: _with(arming, {"begins": translation.unix_there}),
    "senses": lambda senses, translation: [_with(each, {"wall": translation.nanoseconds_there}) for each in senses],
}
"""The fields of a score that hold times."""
