"""Translates times between two machines, and checks the messages of a stage over there.

No other module knows that their clocks differ. A stage there gets its own monotonic and Unix times, and its parent here
gets times of this machine. The types of messages mark the times in them (`score/json_types.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, get_args, get_origin

from improv_core.hosts.clock_offset import RemoteClock
from improv_core.protocol.commands import COMMANDS
from improv_core.protocol.decoding import by_type
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.score.json_types import Clock, TimeOn, hints_of

SECOND = 1_000_000_000
"""Nanoseconds."""
_TO_STAGE, _FROM_STAGE = by_type(ToStage), by_type(FromStage)

Changes = Mapping[Clock, Callable[[Any], Any]]
"""The translation of a time on each clock."""


@dataclass(frozen=True, slots=True)
class TimeTranslation:
    """The monotonic clock there, and the lead of Unix time over monotonic time on both sides, in nanoseconds: `lead`
    here, and `remote_lead` there. `asleep` are the seconds by which the machine there has slept longer."""

    clock: RemoteClock
    lead: int
    remote_lead: int
    asleep: float


def to_remote(message: Mapping[str, Any], translation: TimeTranslation) -> dict[str, Any]:
    """Return a checked message to the stage, with the times of its machine."""
    remote, lead, remote_lead = translation.clock.remote, translation.lead, translation.remote_lead
    changes: Changes = {
        "monotonic": remote,
        "unix": lambda time: remote(time - lead / SECOND) + remote_lead / SECOND,
        "unix_nanoseconds": lambda time: _in_nanoseconds(remote, time - lead) + remote_lead,
        "asleep": lambda slept: slept + translation.asleep,
    }
    return dict(_translated(message, _TO_STAGE[message["type"]], changes))


def to_local(message: Mapping[str, Any], translation: TimeTranslation) -> dict[str, Any] | None:
    """Return a message from the stage, with the times of this machine; None for messages that no stage of real robots
    sends.

    Whoever controls the machine there may send anything. So it can't open a page here, or request things that only a
    page may, such as a change of the program.
    """
    local, lead, remote_lead = translation.clock.local, translation.lead, translation.remote_lead
    changes: Changes = {
        "monotonic": local,
        "unix": lambda time: local(time - remote_lead / SECOND) + lead / SECOND,
        "unix_nanoseconds": lambda time: _in_nanoseconds(local, time - remote_lead) + lead,
    }
    kind = message["type"]
    if kind == "request":
        row = COMMANDS.get(message["command"]["type"])
        if not row or "ros" not in row.by:
            return None
        command = {**_translated(message["command"], row.message, changes)}
        command.pop("anyway", None)
        if row.starts:
            command["by"] = "ros"  # there is no person there
        return {**message, "command": command}
    if kind == "ready":
        return {name: message[name] for name in ("type", "protocol", "sink", "real")}
    return None if kind == "link" else dict(_translated(message, _FROM_STAGE[kind], changes))


def _in_nanoseconds(change: Callable[[float], float], time: int) -> int:
    """Return another time than this one in nanoseconds, of which floats of seconds would lose 200."""
    return time + round((change(time / SECOND) - time / SECOND) * SECOND)


def _translated(value: Any, hint: Any, changes: Changes) -> Any:
    """Return a value of a type with all its times changed."""
    if value is None or not _has_times(hint):
        return value
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is None:  # a TypedDict
        hints = hints_of(hint)
        return {name: _translated(each, hints.get(name, Any), changes) for name, each in value.items()}
    if origin is Annotated and (marks := [each for each in arguments if isinstance(each, TimeOn)]):
        return changes[marks[0].clock](value)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return {name: _translated(each, arguments[1], changes) for name, each in value.items()}
    if isinstance(origin, type) and issubclass(origin, Sequence):
        return [_translated(each, arguments[0], changes) for each in value]
    return _translated(value, arguments[0], changes)  # with limits, or perhaps null


@lru_cache
def _has_times(hint: Any) -> bool:
    inner = hints_of(hint).values() if hasattr(hint, "__required_keys__") else get_args(hint)
    return isinstance(hint, TimeOn) or any(map(_has_times, inner))
