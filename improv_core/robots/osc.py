"""Reads the section `[osc]` of an `improv.toml`: the programs with which it exchanges OSC messages."""

from __future__ import annotations

import re
from collections.abc import Mapping
from ipaddress import AddressValueError, IPv4Address
from typing import Any

from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.osc import HERE, SONIC_PI, Osc, Peer

_PEER = re.compile(r"([A-Za-z0-9][A-Za-z0-9.-]{0,252}):([0-9]{1,5})")
LAST_PORT = 65535


def read_osc(reading: TomlReading, table: Mapping[str, Any]) -> Osc | None:
    """Read the section; None if it has nothing valid. Errors are reported."""
    values = reading.values(("osc",), table)
    port = values.get("listen")
    host = _host(reading, ("osc", "host"), table)
    if "host" in table and "listen" not in table:
        reading.at_key(("osc", "host"), "`host` sets where Improv listens: add `listen`, a port", whole=True)
    listen = Peer(host or HERE, port) if port is not None else None
    send = tuple(_peers(reading, ("osc", "send"), table["send"], listen)) if "send" in table else ()
    time_tags = values.get("time_tags", True)
    if time_tags and any(peer.port == SONIC_PI for peer in send):
        reading.warn_value(
            ("osc", "send"), "Sonic Pi, which listens on 4560, reads no bundles: add `time_tags = false`"
        )
    return Osc(send, listen, time_tags) if listen or send else None


def _host(reading: TomlReading, keys: Keys, table: Mapping[str, Any]) -> str | None:
    host = reading.text(keys, table)
    if host is None or host == "localhost":
        return host
    try:
        return str(IPv4Address(host))
    except AddressValueError:
        reading.at_value(keys, 'write `host` as an IPv4 address of this machine, such as `"127.0.0.1"`')
        return None


def _peers(reading: TomlReading, keys: Keys, value: Any, listen: Peer | None) -> list[Peer]:
    if not isinstance(value, list) or not value:
        reading.at_value(keys, 'write `send` as a list of addresses: `["127.0.0.1:9000"]`')
        return []
    found: list[Peer] = []
    for place, item in enumerate(value):
        written = _PEER.fullmatch(item) if isinstance(item, str) else None
        if not written or not 1 <= int(written[2]) <= LAST_PORT:
            reading.at_value((*keys, place), 'write a host and a port: `"127.0.0.1:9000"`')
            continue
        peer = Peer(written[1], int(written[2]))
        if listen and peer.is_here and peer.port == listen.port:
            reading.at_value((*keys, place), "Improv itself listens on this port: send to another one")
        else:
            found.append(peer)
    return found
