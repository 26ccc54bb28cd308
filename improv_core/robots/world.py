"""Reads the section `[world]` of an `improv.toml`: the size of the floor, walls, circles, and boxes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from improv_core.robots.toml_reading import Range, TomlReading
from improv_core.robots.toml_text import Keys
from improv_core.score.world import Box, Circle, Wall, World

_KEYS = ("size", "walls", "circles", "boxes")
_PLACE: Range = ("meters", -1000, 1000)
_LENGTH: Range = ("meters", 0.001, 1000)
_CIRCLE: Mapping[str, Range] = {"x": _PLACE, "y": _PLACE, "radius": _LENGTH}
_BOX: Mapping[str, Range] = {
    "x": _PLACE,
    "y": _PLACE,
    "width": _LENGTH,
    "height": _LENGTH,
    "heading": ("degrees", -360, 360),
}


def read_world(reading: TomlReading, value: Any) -> World:
    """The valid content of the section as a world. Errors are reported."""
    table = reading.table(("world",), value, _KEYS)
    size = _numbers(reading, ("world", "size"), table["size"], 2, _LENGTH, "[6, 4]") if "size" in table else None
    walls = [
        _numbers(reading, keys, item, 4, _PLACE, "[0, 0, 2, 0]: from x, y to x, y")
        for keys, item in _items(reading, table, "walls")
    ]
    circles = [
        _obstacle(reading, keys, item, _CIRCLE, ("radius",), "{ x = 1, y = 0, radius = 0.3 }")
        for keys, item in _items(reading, table, "circles")
    ]
    boxes = [
        _obstacle(reading, keys, item, _BOX, ("width", "height"), "{ x = 1, y = 0, width = 0.5, height = 1 }")
        for keys, item in _items(reading, table, "boxes")
    ]
    return World(
        (size[0], size[1]) if size else None,
        tuple(Wall(*wall) for wall in walls if wall),
        tuple(Circle(**circle) for circle in circles if circle),
        tuple(Box(**{**box, "heading": math.radians(box["heading"])}) for box in boxes if box),
    )


def _items(reading: TomlReading, table: Mapping[str, Any], name: str) -> list[tuple[Keys, Any]]:
    items = table.get(name, [])
    if isinstance(items, list):
        return [(("world", name, place), item) for place, item in enumerate(items)]
    reading.at_value(("world", name), f"write `{name}` as a list, in `[` and `]`")
    return []


def _numbers(
    reading: TomlReading, keys: Keys, value: Any, count: int, allowed: Range, example: str
) -> list[float] | None:
    if not isinstance(value, list) or len(value) != count:
        reading.at_value(keys, f"write {count} numbers in meters, such as {example}")
        return None
    numbers = [reading.number((*keys, place), item, allowed) for place, item in enumerate(value)]
    right = [number for number in numbers if number is not None]
    return right if len(right) == count else None


def _obstacle(
    reading: TomlReading, keys: Keys, value: Any, ranges: Mapping[str, Range], needed: tuple[str, ...], example: str
) -> dict[str, float] | None:
    """All numbers of an obstacle. Position and heading default to 0."""
    if not isinstance(value, dict):
        reading.at_value(keys, f"write it in meters: `{example}`")
        return None
    table = reading.table(keys, value, tuple(ranges))
    missing = [name for name in needed if name not in value]
    if missing:
        reading.at_value(keys, f"add `{missing[0]}`, in meters")
        return None
    found = reading.numbers(keys, table, ranges)
    if any(name not in found for name in needed):
        return None
    return {name: found.get(name, 0.0) for name in ranges}
