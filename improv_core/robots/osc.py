"""Reads the section `[osc]` of an `improv.toml`: the programs with which it exchanges OSC messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from improv_core.robots.toml_reading import TomlReading
from improv_core.score.osc import HERE, SONIC_PI, Osc, Peer, peer_of


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
