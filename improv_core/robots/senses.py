"""Reads the section `[senses]` of `improv.toml`: topics, keys, and OSC messages that decide what robots sense."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from typing import Any, cast

from improv_core.robots.ros_names import ros_name
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import Range, TomlReading
from improv_core.score.senses import CUE, Key, Message, OscName, Source, Topic
from improv_core.syntax.vocabulary import WORDS

_NAME = re.compile(r"[^\W\d]\w*")
_ALONE: Mapping[str, tuple[str, type[Key | OscName]]] = {
    "key": ("this sense has a key", Key),
    "osc": ("OSC messages decide this sense", OscName),
}
"""Keys beside which a sense has no others, and the source that each stands for."""
_LIMITS: Mapping[str, Range] = {
    "sensor_msgs/LaserScan": ("meters", 0, 1000),
    "sensor_msgs/Range": ("meters", 0, 1000),
    "std_msgs/Float32": ("the unit of the topic", -1e6, 1e6),
    "nav_msgs/Odometry": ("m/s", 0, 100),
}
"""Messages that carry a number, and the range of a limit for it."""
_ONLY: Mapping[str, Collection[str]] = {
    "from": ("sensor_msgs/LaserScan",),
    "to": ("sensor_msgs/LaserScan",),
    "button": ("sensor_msgs/Joy",),
    "below": _LIMITS,
    "above": _LIMITS,
}
"""Messages that a key is for, if not for all."""
_ON_CHANGE = ("std_msgs/Bool", "sensor_msgs/Joy")  # often published only on a change


def read_senses(reading: TomlReading, tables: Mapping[str, Any]) -> dict[str, Source]:
    """Read the declared senses that are valid, by name. Errors are reported. Relative topics stay relative."""
    made: dict[str, Source] = {}
    for name, value in tables.items():
        keys = ("senses", name)
        table = reading.table(keys, value)
        if not _NAME.fullmatch(name) or name in WORDS:
            reading.at_key(keys, f"`{name}` can't be the name of a sense: use a word of your own")
        elif name == CUE:
            reading.at_key(keys, f"`{CUE}` comes from people: choose another name")
        elif isinstance(value, dict) and (source := _source(reading, keys, table)):
            made[name] = source
    return made


def _source(reading: TomlReading, keys: Keys, table: Mapping[str, Any]) -> Source | None:
    for only, (decides, made) in _ALONE.items():
        if only in table:
            for other in [name for name in table if name != only]:
                reading.at_key((*keys, other), f"{decides}, so `{other}` has no effect: remove it")
            value = reading.text((*keys, only), table[only])
            return made(value) if value else None
    if "topic" not in table:
        reading.at_key(keys, "add `topic` and `message`, `key`, or `osc`", whole=True)
        return None
    if "message" not in table:
        reading.at_key((*keys, "topic"), "add `message`, the type on this topic, such as `std_msgs/Bool`", whole=True)
        return None
    topic = ros_name(reading, (*keys, "topic"), reading.text((*keys, "topic"), table["topic"]), "")
    message = reading.text((*keys, "message"), table["message"])
    return _topic(reading, keys, table, cast(Message, message)) if topic and message else None


def _topic(reading: TomlReading, keys: Keys, table: Mapping[str, Any], message: Message) -> Topic | None:
    for name in [name for name in table if message not in _ONLY.get(name, (message,))]:
        reading.at_key((*keys, name), f"`{name}` is not for {message}: remove it")
    allowed = {name: value for name, value in table.items() if message in _ONLY.get(name, (message,))}
    limits: Mapping[str, float] = {}
    if message in _LIMITS:
        written = [name for name in ("below", "above") if name in allowed]
        numbers = {name: reading.number((*keys, name), allowed[name], _LIMITS[message]) for name in written}
        limits = {name: number for name, number in numbers.items() if number is not None}
        if not written:
            reading.at_value(
                (*keys, "message"), f"add `below` or `above`, a limit in {_LIMITS[message][0]}", whole=True
            )
        elif len(written) == 2:
            reading.at_key((*keys, "above"), "write `below` or `above`, not both")
        if len(written) != 1 or not limits:
            return None
    sector = _sector(reading, keys, allowed)
    button = reading.integer((*keys, "button"), allowed["button"]) if "button" in allowed else None
    timeout = _timeout(reading, keys, allowed, message)
    return Topic(allowed["topic"], message, limits.get("below"), limits.get("above"), *sector, button, timeout)


def _sector(reading: TomlReading, keys: Keys, table: Mapping[str, Any]) -> tuple[float, float]:
    numbers = reading.values(keys, {name: table[name] for name in ("from", "to") if name in table})
    found = {"from": -180.0, "to": 180.0, **numbers}
    start, end = found["from"], found["to"]
    if not start <= end <= start + 360:
        name = "from" if "from" in table else "to"
        reading.at_value(
            (*keys, name), "`from` must be less than `to`, by at most 360: degrees count counterclockwise", whole=True
        )
    return math.radians(start), math.radians(end)


def _timeout(reading: TomlReading, keys: Keys, table: Mapping[str, Any], message: Message) -> float:
    default = Topic("", message).timeout
    if "timeout" not in table:
        return default
    if table["timeout"] == 0 and message in _ON_CHANGE and not isinstance(table["timeout"], bool):
        return 0.0
    found = reading.number((*keys, "timeout"), table["timeout"])
    return default if found is None else found
