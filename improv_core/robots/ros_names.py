"""Reads names of ROS 2 topics and services in an `improv.toml`."""

from __future__ import annotations

import re

from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.score import in_namespace

_ROS_NAME = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+")  # as in rmw's validate_full_topic_name.c
_LONGEST_ROS_NAME = 247  # also there: 255, less 8 for prefixes


def ros_name(reading: TomlReading, keys: Keys, written: str | None, namespace: str) -> str | None:
    """Return the full name of a topic or a service, if any, in this namespace unless it starts with `/`."""
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
