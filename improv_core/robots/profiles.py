"""Reads the kinds of robots from an `improv.toml`, and names the sources of the built-in ones."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from improv_core.robots.bodies import read_body
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.profiles import BUILT_IN, DEFAULT, MOTIONS, PUPPET, Profile

MAX_SCALE = 2.0
"""The largest ratio between the velocity sent to a robot and its intended one. Wheels are never that wrong: a larger
ratio is a typing error."""
_MOTORS_ONLY = ("wheel_error", "noise")


def read_profiles(reading: TomlReading, tables: Mapping[str, Any]) -> dict[str, Profile]:
    """Read all profiles, including the built-in ones. Each is made after its base."""
    own = {name: reading.table(("profiles", name), value) for name, value in tables.items()}
    known = dict.fromkeys([*BUILT_IN, *own])
    made = {name: profile for name, profile in BUILT_IN.items() if name != PUPPET.name or name not in own}
    for first in own:
        if first in BUILT_IN and first != PUPPET.name:
            message = f"`{first}` is built in: choose another name and use it as `base`"
            reading.at_key(("profiles", first), message)
        chain: list[str] = []
        name: str | None = first
        while name and name not in made and name not in chain:
            chain.append(name)
            name = _base(reading, name, own[name], known)
        if name in chain:
            message = f"with base `{name}`, `{chain[-1]}` is based on itself: choose another base"
            reading.at_value(("profiles", chain[-1], "base"), message)
            name = None
        profile = made[name] if name else DEFAULT
        for link in reversed(chain):
            profile = made[link] = _profile(reading, link, own[link], profile)
    return made


def _base(reading: TomlReading, name: str, table: Mapping[str, Any], known: Collection[str]) -> str | None:
    if "base" not in table and "step" not in table:
        message = "add `step`, in meters, or `base`, the profile to take all other values from"
        reading.at_key(("profiles", name), message, whole=True)
    return reading.one_of(("profiles", name, "base"), table.get("base"), known, whole=True)


def _profile(reading: TomlReading, name: str, table: Mapping[str, Any], base: Profile) -> Profile:
    keys = ("profiles", name)
    changes = reading.values(keys, table)
    for key in ("quarter_turn", "commanded_quarter_turn"):
        if key in changes:
            changes[key] = math.radians(changes[key])
    for key, scale in (("step", "linear_scale"), ("quarter_turn", "angular_scale")):
        if commanded := changes.pop(f"commanded_{key}", None):
            changes[scale] = commanded / changes.get(key, getattr(base, key))
            if not 1 / MAX_SCALE <= changes[scale] <= MAX_SCALE:
                message = f"this is far from `{key}`: write from {1 / MAX_SCALE:g} to {MAX_SCALE:g} times as much"
                reading.at_value((*keys, f"commanded_{key}"), message, whole=True)
    chosen = changes.pop("motions", ())
    motions = tuple(motion for motion in MOTIONS if motion in chosen)
    if "wheel_error" in changes:
        changes["wheel_error"] = tuple(changes["wheel_error"])
    of_body: dict[str, Any] = {key: changes.pop(key, None) for key in ("joint_states", "home", "urdf")}
    body = read_body(reading, keys, table, of_body, base.body)
    profile = replace(base, name=name, motions=motions or base.motions, body=body, **changes)
    if profile.dynamics != "motors":
        for key in _MOTORS_ONLY:
            if key in table:
                reading.at_key(
                    (*keys, key), f'`{key}` works only with `dynamics = "motors"`: add that line', whole=True
                )
    return profile


SOURCES: Mapping[str, str] = {
    "turtlesim": "https://github.com/ros/ros_tutorials/pull/131",
    "turtlebot3_burger": "https://emanual.robotis.com/docs/en/platform/turtlebot3/features/#specifications",
    "turtlebot3_waffle": "https://emanual.robotis.com/docs/en/platform/turtlebot3/features/#specifications",
    "turtlebot4": "https://turtlebot.github.io/turtlebot4-user-manual/overview/features.html",
    "create3": "https://iroboteducation.github.io/create3_docs/api/safety/",
    "jackal": "https://github.com/clearpathrobotics/clearpath_common/blob/jazzy/clearpath_control/config/j100/control.yaml",
    "husky": "https://github.com/clearpathrobotics/clearpath_common/blob/jazzy/clearpath_control/config/a200/control.yaml",
    "leo_rover": "https://docs.fictionlab.pl/leo-rover/documentation/specification",
    "holonomic": "https://github.com/husarion/rosbot_ros",
    "quadrotor": "https://github.com/bitcraze/crazyflie-firmware/blob/master/src/platform/interface/platform_defaults_cf2.h",
    "thymio2": "https://github.com/enki-community/enki",
}
