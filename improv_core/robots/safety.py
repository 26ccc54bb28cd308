"""Reads from an `improv.toml` what stops real robots, and what happens after their faults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, get_args

from improv_core.robots.ros_names import ros_name
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.faults import Fault, FaultRules
from improv_core.score.score import Deadman, Preflight, Safety


def read_safety(
    reading: TomlReading,
    ros: Mapping[str, Any],
    values: Mapping[str, Any],
    namespace: str,
    on: Mapping[str, Any],
    preflight: Mapping[str, Any],
) -> Safety:
    """Read `[ros]`, whose numbers, flags, and choices are in `values`, `[on]`, and `[preflight]`. Topics are in the
    namespace unless they begin with `/`."""
    deadman = _deadman(reading, ros["deadman"], namespace) if "deadman" in ros else None
    stop = ros_name(reading, ("ros", "stop"), ros, namespace)
    if stop and deadman and stop == deadman.topic:
        message = "the deadman button is on this topic: the emergency stop needs one of its own"
        reading.at_value(("ros", "stop"), message)
    return Safety(
        stop,
        deadman,
        values.get("rejoin", Safety().rejoin),
        start_without=values.get("start_without", True),
        faults=_faults(reading.values(("on",), on)),
        preflight=_preflight(reading.values(("preflight",), preflight)),
    )


def _faults(values: Mapping[str, Any]) -> FaultRules:
    default = FaultRules()
    responses = {fault: values[fault] for fault in get_args(Fault) if fault in values}
    angle = math.radians(values["angle"]) if "angle" in values else default.angle
    return FaultRules(responses, values.get("distance", default.distance), angle)


def _preflight(values: Mapping[str, Any]) -> Preflight:
    default = Preflight()
    turn = math.radians(values["degrees"]) if "degrees" in values else default.turn
    return Preflight(values.get("distance", default.distance), turn)


def _deadman(reading: TomlReading, value: Any, namespace: str) -> Deadman | None:
    keys = ("ros", "deadman")
    if not isinstance(value, dict) or not value.keys() >= {"topic", "button"}:
        reading.at_value(keys, 'write `deadman` as a topic and a button: `{ topic = "/joy", button = 4 }`', whole=True)
        return None
    table = reading.table(keys, value)
    topic = ros_name(reading, (*keys, "topic"), table, namespace)
    button = reading.integer((*keys, "button"), table["button"])
    return Deadman(topic, button) if topic and button is not None else None
