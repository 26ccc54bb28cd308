"""The environment variables that decide which robots ROS 2 can reach, and their meaning in each release."""

from __future__ import annotations

from collections.abc import Mapping

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"
PEERS = "ROS_STATIC_PEERS"
SERVER = "ROS_DISCOVERY_SERVER"
SUPER_CLIENT = "ROS_SUPER_CLIENT"
REACH = {
    "LOCALHOST": "this machine only",
    "SUBNET": "the whole subnet",
    "OFF": "no discovery",
    "SYSTEM_DEFAULT": "as the middleware is configured",
}
"""The values of `RANGE`, in words."""

BEFORE_RANGES = ("foxy", "galactic", "humble")
"""Releases that know only LOCALHOST_ONLY, and reach the subnet unless it is 1 (their rcl/localhost.c)."""
WITH_BOTH = ("iron", "jazzy")
"""Releases in which LOCALHOST_ONLY=1 overrides RANGE and PEERS (rcl#1069); later ones ignore it (rcl#1169)."""


def limited(env: Mapping[str, str], setting: str | None = None) -> dict[str, str]:
    """Return this environment for a stage. By default it reaches only this machine.

    So nobody moves a neighbor's robot. `setting`, a key of `REACH`, counts if the environment sets no range.
    """
    # If RANGE were set but empty, rcl would use the subnet (discovery_options.c).
    made = {**env, RANGE: env.get(RANGE) or setting or "LOCALHOST"}
    if _release(env) in BEFORE_RANGES and made[RANGE] not in ("SUBNET", "SYSTEM_DEFAULT"):
        made[LOCALHOST_ONLY] = "1"  # even if it is 0: sourcing Humble sets that by itself
    if server(env) and not env.get(SUPER_CLIENT):
        made[SUPER_CLIENT] = "TRUE"  # otherwise, the server doesn't list the other nodes and their topics
    return made


def server(env: Mapping[str, str]) -> str | None:
    """The Fast DDS discovery server of this environment, if any. It overrides RANGE.

    So LOCALHOST also reaches robots on other machines if they use the same server (tests/ros/test_hosts.py).
    """
    uses_fast_dds = env.get("RMW_IMPLEMENTATION", "rmw_fastrtps").startswith("rmw_fastrtps")
    return (uses_fast_dds and env.get(SERVER)) or None


def reached(env: Mapping[str, str]) -> str:
    """The real range of a stage with this environment, which `limited` has made: a key of `REACH`.

    Disregards a discovery server, which overrides the range.
    """
    only = env.get(LOCALHOST_ONLY) == "1"
    if _release(env) in BEFORE_RANGES:
        return "LOCALHOST" if only else "SUBNET"
    if (_release(env) in WITH_BOTH and only) or env[RANGE] not in REACH:  # rcl treats unknown values as LOCALHOST
        return "LOCALHOST"
    return env[RANGE]


def described(env: Mapping[str, str]) -> str:
    """The reach of a stage with this environment, which `limited` has made, in words."""
    domain = f"domain {env.get('ROS_DOMAIN_ID') or 0}"
    if asked := server(env):
        return f"{domain}, all robots listed by the discovery server {asked}"
    reach = reached(env)
    peers = f", plus {PEERS} {env[PEERS]}" if env.get(PEERS) and reach != "OFF" and not _ignores_peers(env) else ""
    return f"{domain}, {REACH[reach]}{peers}"


def advice(env: Mapping[str, str], wanted: str) -> str:
    """The variables to set so that a stage started in this environment reaches `wanted`: LOCALHOST or SUBNET."""
    change = {RANGE: wanted}
    if reached(limited({**env, **change})) != wanted:
        change[LOCALHOST_ONLY] = "0"
    return " and ".join(f"{name}={value}" for name, value in change.items())


def unsourced(sourced: Mapping[str, str], env: Mapping[str, str]) -> dict[str, str]:
    """Return a sourced environment that reaches no farther than the one it was sourced in.

    Sourcing sets the subnet as if somebody had asked for it (ros_environment, 1.ros_discovery.dsv.in; before Iron
    1.ros_localhost_only.dsv.in).
    """
    own = {name: env[name] for name in (RANGE, LOCALHOST_ONLY) if name in env}
    return {name: value for name, value in sourced.items() if name not in (RANGE, LOCALHOST_ONLY)} | own


def _release(env: Mapping[str, str]) -> str:
    return env.get("ROS_DISTRO") or "jazzy"  # the wheels from PyPI set none


def _ignores_peers(env: Mapping[str, str]) -> bool:
    return _release(env) in BEFORE_RANGES or (_release(env) in WITH_BOTH and env.get(LOCALHOST_ONLY) == "1")
