"""Reads from an `improv.toml` the robots whose stages run on other machines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

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
        domain = reading.integer((*keys, "domain"), table["domain"]) if "domain" in table else None
        made[name] = Host(name, domain, reading.one_of((*keys, "rmw"), table))
    return made


def host_of(reading: TomlReading, robot: str, table: Mapping[str, Any], hosts: Mapping[str, Host]) -> Host | None:
    """Return the machine whose stage moves a robot; None if that is this one."""
    keys = ("robots", robot)
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
    patience = reading.numbers(keys, table).get("link_patience", host.patience)
    return replace(host, patience=patience)
