"""Reads from an `improv.toml` the stages on other machines and the stages of other outputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from improv_core.diagnostics import likely
from improv_core.robots.schema_robots import PLAIN_HOST
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.installed import Value, outputs_installed, settings_of
from improv_core.score.score import DeviceAddress, Host, is_address, is_host


def read_hosts(reading: TomlReading, tables: Mapping[str, Any]) -> dict[str, Host]:
    """Read the other machines in `[hosts.NAME]`, by their names."""
    made = {}
    for name, value in tables.items():
        keys = ("hosts", name)
        table = reading.table(keys, value)
        if not is_host(name):
            reading.at_key(keys, f"`{name}` can't be a host: {PLAIN_HOST}")
            continue
        values = reading.values(keys, table)
        made[name] = Host(name, values.get("domain"), values.get("rmw"))
    return made


def host_of(reading: TomlReading, keys: Keys, values: Mapping[str, Any], hosts: Mapping[str, Host]) -> Host | None:
    """Return the machine whose stage moves a robot; None if that is this one."""
    name, patience = values.get("host"), values.get("link_patience")
    if output := values.get("output"):
        if name is not None:
            reading.at_key((*keys, "host"), "`output` moves this robot from here: remove one of the two")
        for key in {"topic", "message", "frame"} & values.keys():
            reading.at_key((*keys, key), f"`output` moves this robot without ROS 2: remove `{key}`", whole=True)
        return _output(reading, keys, output)
    if name is None:
        if patience is not None:
            message = "`link_patience` is about a robot with a `host`: add it"
            reading.at_key((*keys, "link_patience"), message, whole=True)
        return None
    host = hosts.get(name, Host(name))
    return host if patience is None else replace(host, patience=patience)


def device_of(
    reading: TomlReading, keys: Keys, table: Mapping[str, Any], values: Mapping[str, Any]
) -> DeviceAddress | None:
    """Return the place where a robot's output finds it; None if it has no output. `values` are the valid ones."""
    for name in ("address", "node", "settings"):
        if name in table and "output" not in table:
            reading.at_key((*keys, name), f"`{name}` is about a robot with an `output`: add it", whole=True)
    if "output" not in table:
        return None
    address = values.get("address")
    if address is None or not is_address(address):
        message = "an `output` needs an `address`, such as `serial:/dev/ttyACM0` or `tcp:localhost:33333`"
        (reading.at_key if address is None else reading.at_value)(
            (*keys, "output" if address is None else "address"), message, whole=True
        )
        return None
    return DeviceAddress(address, values.get("node"), _settings(reading, (*keys, "settings"), table))


def _settings(reading: TomlReading, keys: Keys, table: Mapping[str, Any]) -> dict[str, Value]:
    """Read the settings of a robot's output, as far as the output declares them."""
    if "settings" not in table:
        return {}
    found = reading.table(keys, table["settings"])
    declared = settings_of(str(table["output"]))
    if declared is None:  # its stage says why it can't be imported
        return found
    for name, value in found.items():
        if name not in declared:
            reading.unknown_key((*keys, name), declared)
        elif wrong := declared[name].problem(value):
            reading.at_value((*keys, name), f"write `{name}` {wrong}")
    return found


def _output(reading: TomlReading, keys: Keys, name: str) -> Host | None:
    known = outputs_installed()
    if known and name not in known:
        near = likely(name, known)
        hint = f"did you mean `{near}`? If not, " if near else ""
        message = f"no output `{name}` is installed: {hint}install its package with `pip`"
        if name in ("ros", "simulator"):
            message = "ROS 2 and the simulator need no `output`: remove it"
        reading.at_value((*keys, "output"), message, (near and f'"{near}"') or "")
        return None
    return Host(name, output=True)
