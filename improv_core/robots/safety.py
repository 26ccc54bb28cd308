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
    values: Mapping[str, Any],
    namespace: str,
    on: Mapping[str, Any],
    preflight: Mapping[str, Any],
) -> Safety:
    """Read `[ros]`, whose valid values are given, `[on]`, and `[preflight]`. Topics are in the namespace unless they
    begin with `/`."""
    deadman, held = None, values.get("deadman")
    if held and (topic := ros_name(reading, ("ros", "deadman", "topic"), held["topic"], namespace)):
        deadman = Deadman(topic, held["button"])
    stop = ros_name(reading, ("ros", "stop"), values.get("stop"), namespace)
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
