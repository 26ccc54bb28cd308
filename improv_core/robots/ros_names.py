"""Reads names of ROS 2 topics and services in an `improv.toml`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.score import in_namespace

_NODE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")  # as in rmw's validate_node_name.c
_LONGEST_NODE_NAME = 200  # 255 there, but the names of services come after it
_ROS_NAME = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+")  # as in rmw's validate_full_topic_name.c
_LONGEST_ROS_NAME = 247  # also there: 255, less 8 for prefixes
_FRAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_./-]{0,199}")  # tf2 refuses a leading `/`


def ros_name(reading: TomlReading, keys: Keys, table: Mapping[str, Any], namespace: str) -> str | None:
    """Read the full name of a topic or a service. The namespace applies unless the name starts with `/`."""
    written = reading.text(keys, table)
    if written is None:
        return None
    whole = in_namespace(written, namespace)
    if len(whole) > _LONGEST_ROS_NAME:
        reading.at_value(keys, f"this name is too long for ROS 2: use at most {_LONGEST_ROS_NAME} characters")
    elif not _ROS_NAME.fullmatch(whole):
        reading.at_value(keys, "use the letters a to z, digits, and `_` between the `/`, not starting with a digit")
    else:
        return whole
    return None


def node_name(reading: TomlReading, keys: Keys, table: Mapping[str, Any]) -> str | None:
    """Read the name of a node, without a namespace."""
    name = reading.text(keys, table)
    if name is None or (_NODE_NAME.fullmatch(name) and len(name) <= _LONGEST_NODE_NAME):
        return name
    reading.at_value(keys, "use the letters a to z, digits, and `_`, not starting with a digit, without `/`")
    return None


def frame_id(reading: TomlReading, keys: Keys, table: Mapping[str, Any]) -> str | None:
    """Read the name of a coordinate frame, as tf2 takes it."""
    name = reading.text(keys, table)
    if name is None or _FRAME.fullmatch(name):
        return name
    reading.at_value(keys, "use the letters a to z, digits, `_`, `.`, `-`, and `/`, but no `/` at the start")
    return None
