"""Reads the section `[world]` of an `improv.toml`: the floor, walls, circles, boxes, and the distances to keep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from improv_core.robots.schema import known
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.world import Box, Circle, Wall, World


def read_world(reading: TomlReading, table: Mapping[str, Any]) -> World:
    """Read the valid content of the section as a world. Errors are reported."""
    size = _numbers(reading, ("world", "size"), table["size"]) if "size" in table else None
    walls = [_numbers(reading, keys, item, ": from x, y to x, y") for keys, item in _items(reading, table, "walls")]
    circles = [_obstacle(reading, keys, item) for keys, item in _items(reading, table, "circles")]
    boxes = [_obstacle(reading, keys, item) for keys, item in _items(reading, table, "boxes")]
    values = reading.values(("world",), table)
    return World(
        (size[0], size[1]) if size else None,
        tuple(Wall(*wall) for wall in walls if wall),
        tuple(Circle(**circle) for circle in circles if circle),
        tuple(Box(**{**box, "heading": math.radians(box["heading"])}) for box in boxes if box),
        values.get("margin", 0.0),
        values.get("keep_apart"),
    )


def _items(reading: TomlReading, table: Mapping[str, Any], name: str) -> list[tuple[Keys, Any]]:
    items = table.get(name, [])
    if isinstance(items, list):
        return [(("world", name, place), item) for place, item in enumerate(items)]
    reading.at_value(("world", name), f"write `{name}` as a list, in `[` and `]`")
    return []


def _numbers(reading: TomlReading, keys: Keys, value: Any, note: str = "") -> list[float] | None:
    key = known(keys)
    if not isinstance(value, list) or len(value) != key.count:
        reading.at_value(keys, f"write {key.count} numbers in meters, such as {key.example}{note}")
        return None
    numbers = [reading.number((*keys, place), item) for place, item in enumerate(value)]
    right = [number for number in numbers if number is not None]
    return right if len(right) == key.count else None


def _obstacle(reading: TomlReading, keys: Keys, value: Any) -> dict[str, float] | None:
    """Read all numbers of an obstacle. Position and heading default to 0."""
    key = known(keys)
    if not isinstance(value, dict):
        reading.at_value(keys, f"write it in meters: `{key.example}`")
        return None
    table = reading.table(keys, value)
    missing = [name for name in key.required if name not in value]
    if missing:
        reading.at_value(keys, f"add `{missing[0]}`, in meters", whole=True)
        return None
    found = reading.values(keys, table)
    if any(name not in found for name in key.required):
        return None
    return {name: found.get(name, 0.0) for name in key.keys}
