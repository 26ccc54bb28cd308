"""Reads sections of an `improv.toml`: the song (`[music]`), the programs that exchange OSC messages with a dance
(`[osc]`), what stops real robots and what follows their faults, and the surroundings (`[world]`)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from improv_core.robots.ros_names import ros_name
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.faults import Fault, FaultRules
from improv_core.score.music import CONTENT_TYPES, Music, is_inside, is_song
from improv_core.score.osc import HERE, SONIC_PI, Osc, Peer, peer_of
from improv_core.score.score import Deadman, Preflight, Safety
from improv_core.score.world import Box, Circle, Wall, World

_CENTER = {"x": 0.0, "y": 0.0}
"""The place of an obstacle, unless the file sets another one."""


def read_music(reading: TomlReading, table: Mapping[str, Any], path: Path | None) -> Music:
    """Read the section in the file at `path`. Without a valid `file`, there is no song: a dance plays without its song,
    so this is only a warning."""
    values = reading.values(("music",), table)
    file = values.get("file", "")
    if file and not is_song(file):
        reading.warn_value(("music", "file"), f"pages can't play this: write a file that ends in {_endings()}")
        file = ""
    elif not is_inside(file):
        reading.warn_value(
            ("music", "file"), 'pages can\'t get this: put the song beside this file, and write its name: `"song.mp3"`'
        )
        file = ""
    folder = str(path.parent) if path and path.is_absolute() else ""  # otherwise, there is no file
    song = values.get("first_beat", 0.0), values.get("volume", 1.0), values.get("count_in", False)
    return Music(file, folder, *song)


def _endings() -> str:
    *others, last = (f"`{each}`" for each in CONTENT_TYPES)
    return f"{', '.join(others)}, or {last}"


def read_osc(reading: TomlReading, table: Mapping[str, Any]) -> Osc | None:
    """Read the section; None if it has nothing valid. Errors are reported."""
    values = reading.values(("osc",), table)
    port = values.get("listen")
    if "host" in table and "listen" not in table:
        reading.at_key(("osc", "host"), "`host` sets where Improv listens: add `listen`, a port", whole=True)
    listen = Peer(values.get("host", HERE), port) if port is not None else None
    send = []
    for place, item in enumerate(table["send"] if "send" in values else ()):
        if peer := peer_of(item) if isinstance(item, str) else None:
            if listen and peer.is_here and peer.port == listen.port:
                reading.at_value(("osc", "send", place), "Improv itself listens on this port: send to another one")
            else:
                send.append(peer)
    time_tags = values.get("time_tags", True)
    if time_tags and any(peer.port == SONIC_PI for peer in send):
        reading.warn_value(
            ("osc", "send"), "Sonic Pi, which listens on 4560, reads no bundles: add `time_tags = false`"
        )
    return Osc(tuple(send), listen, time_tags) if listen or send else None


def read_safety(
    reading: TomlReading, values: Mapping[str, Any], namespace: str, on: Mapping[str, Any], preflight: Mapping[str, Any]
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
