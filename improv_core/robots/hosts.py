"""Reads from an `improv.toml` the robots whose stages run on other machines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.score import Host, is_host

_PLAIN = "use a name as in ~/.ssh/config, `user@machine`, or `user@machine:port`: letters, digits, `_`, `.`, and `-`"


def read_hosts(reading: TomlReading, tables: Mapping[str, Any]) -> dict[str, Host]:
    """Read the other machines in `[hosts.NAME]`, by their names."""
    made = {}
    for name, value in tables.items():
        keys = ("hosts", name)
        table = reading.table(keys, value)
        if not is_host(name):
            reading.at_key(keys, f"`{name}` can't be a host: {_PLAIN}")
            continue
        values = reading.values(keys, table)
        made[name] = Host(name, values.get("domain"), values.get("rmw"))
    return made


def host_of(
    reading: TomlReading, keys: Keys, table: Mapping[str, Any], hosts: Mapping[str, Host], patience: float | None
) -> Host | None:
    """Return the machine whose stage moves a robot; None if that is this one."""
    name = reading.text((*keys, "host"), table)
    if name is None:
        if "link_patience" in table:
            reading.at_key(
                (*keys, "link_patience"), "`link_patience` is about a robot with a `host`: add it", given=(keys,)
            )
        return None
    if not is_host(name):
        reading.at_value((*keys, "host"), _PLAIN)
        return None
    host = hosts.get(name, Host(name))
    return host if patience is None else replace(host, patience=patience)
