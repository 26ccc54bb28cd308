"""Reads the section `[world]` of an `improv.toml`: the floor, walls, circles, boxes, and the distances to keep."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from improv_core.robots.toml_reading import TomlReading
from improv_core.score.world import Box, Circle, Wall, World

_CENTER = {"x": 0.0, "y": 0.0}
"""The place of an obstacle, unless the file sets another one."""


def read_world(reading: TomlReading, table: Mapping[str, Any]) -> World:
    """Read the valid content of the section as a world. Errors are reported."""
    values = reading.values(("world",), table)
    boxes = [{**_CENTER, **box, "heading": math.radians(box.get("heading", 0.0))} for box in values.get("boxes", ())]
    return World(
        tuple(values["size"]) if "size" in values else None,
        tuple(Wall(*wall) for wall in values.get("walls", ())),
        tuple(Circle(**{**_CENTER, **circle}) for circle in values.get("circles", ())),
        tuple(Box(**box) for box in boxes),
        values.get("margin", 0.0),
        values.get("keep_apart"),
    )
