"""Reads from an `improv.toml` what stops real robots, and what happens after their faults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast, get_args

from improv_core.robots.ros_names import ros_name
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.faults import Fault, FaultRules, Response
from improv_core.score.score import Deadman, Preflight, Rejoin, Safety


def read_safety(reading: TomlReading, ros: Mapping[str, Any], namespace: str, on: Any, preflight: Any) -> Safety:
    """Read `[ros]`, `[on]`, and `[preflight]`. Topics are in the namespace unless they begin with `/`."""
    return replace(
        _of_ros(reading, ros, namespace), faults=_faults(reading, on), preflight=_preflight(reading, preflight)
    )


def _of_ros(reading: TomlReading, ros: Mapping[str, Any], namespace: str) -> Safety:
    rejoin = reading.one_of(("ros", "rejoin"), ros) or Safety().rejoin
    deadman = _deadman(reading, ros["deadman"], namespace) if "deadman" in ros else None
    stop = ros_name(reading, ("ros", "stop"), ros, namespace)
    if stop and deadman and stop == deadman.topic:
        message = "the deadman button is on this topic: the emergency stop needs one of its own"
        reading.at_value(("ros", "stop"), message)
    start_without = "start_without" not in ros or reading.flag(("ros", "start_without"), ros)
    return Safety(stop, deadman, cast(Rejoin, rejoin), start_without=start_without)


def _faults(reading: TomlReading, value: Any) -> FaultRules:
    table = reading.table(("on",), value)
    numbers, default = reading.numbers(("on",), table), FaultRules()
    responses = {fault: reading.one_of(("on", fault), table) for fault in get_args(Fault)}
    angle = numbers.get("angle")
    return FaultRules(
        {fault: cast(Response, response) for fault, response in responses.items() if response},
        numbers.get("distance", default.distance),
        default.angle if angle is None else math.radians(angle),
    )


def _preflight(reading: TomlReading, value: Any) -> Preflight:
    found, usual = reading.numbers(("preflight",), reading.table(("preflight",), value)), Preflight()
    turn = math.radians(found["degrees"]) if "degrees" in found else usual.turn
    return Preflight(found.get("distance", usual.distance), turn)


def _deadman(reading: TomlReading, value: Any, namespace: str) -> Deadman | None:
    keys = ("ros", "deadman")
    if not isinstance(value, dict) or not value.keys() >= {"topic", "button"}:
        reading.at_value(
            keys, 'write `deadman` as a topic and a button: `{ topic = "/joy", button = 4 }`', given=(keys,)
        )
        return None
    table = reading.table(keys, value)
    topic = ros_name(reading, (*keys, "topic"), table, namespace)
    button = reading.integer((*keys, "button"), table["button"])
    return Deadman(topic, button) if topic and button is not None else None
