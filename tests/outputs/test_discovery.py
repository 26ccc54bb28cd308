"""The robots that ROS 2 can reach, in each release; `tests/ros/test_ros_sink.py` checks a real sink."""

from __future__ import annotations

from itertools import product

import pytest

from improv_core.outputs.ros.discovery import LOCALHOST_ONLY, PEERS, RANGE, REACH, advice, described, limited, unsourced

HERE, SUBNET, NOBODY = REACH["LOCALHOST"], REACH["SUBNET"], REACH["OFF"]
RELEASES = ("foxy", "humble", "iron", "jazzy", "kilted", "rolling")


@pytest.mark.parametrize(
    ("release", "given", "only", "reach"),
    [
        ("humble", None, None, HERE),
        ("humble", None, "0", HERE),  # sourcing Humble sets 0, though nobody set it
        ("humble", None, "1", HERE),
        ("humble", "", "0", HERE),
        ("humble", "SUBNET", None, SUBNET),
        ("humble", "SUBNET", "0", SUBNET),
        ("humble", "SUBNET", "1", HERE),
        ("humble", "OFF", None, HERE),  # it can't do less
        ("humble", "typo", "0", HERE),
        ("foxy", None, "0", HERE),
        ("galactic", "SUBNET", "0", SUBNET),
        ("iron", None, "0", HERE),
        ("iron", "SUBNET", "1", HERE),
        ("jazzy", None, None, HERE),
        ("jazzy", "", None, HERE),
        ("jazzy", "SUBNET", "0", SUBNET),
        ("jazzy", "SUBNET", "1", HERE),
        ("jazzy", "OFF", None, NOBODY),
        ("jazzy", "typo", None, HERE),
        ("jazzy", "SYSTEM_DEFAULT", None, REACH["SYSTEM_DEFAULT"]),
        ("kilted", "SUBNET", "1", SUBNET),
        ("kilted", None, "0", HERE),
        (None, "SUBNET", "1", HERE),  # the wheels from PyPI are Jazzy's
    ],
)
def test_a_stage_describes_its_reach(release: str | None, given: str | None, only: str | None, reach: str) -> None:
    assert described(limited(environment(release, given, only))) == f"domain 0, {reach}"


def test_a_setting_counts_only_if_the_environment_has_none() -> None:
    assert limited({}, "SUBNET")[RANGE] == "SUBNET"
    assert limited({RANGE: "OFF"}, "SUBNET")[RANGE] == "OFF"


def test_a_discovery_server_gives_the_whole_graph() -> None:
    asked = limited({"ROS_DISCOVERY_SERVER": "10.0.0.1:11811"})
    assert asked["ROS_SUPER_CLIENT"] == "TRUE"
    assert described(asked) == "domain 0, all robots listed by the discovery server 10.0.0.1:11811"
    assert limited({"ROS_DISCOVERY_SERVER": "x", "ROS_SUPER_CLIENT": "FALSE"})["ROS_SUPER_CLIENT"] == "FALSE"
    assert "ROS_SUPER_CLIENT" not in limited({"ROS_DISCOVERY_SERVER": ""})


@pytest.mark.parametrize(
    ("env", "expected"),
    [
        ({}, f"domain 7, {HERE}, plus {PEERS} lab.local"),
        ({LOCALHOST_ONLY: "1"}, f"domain 7, {HERE}"),
        ({RANGE: "OFF"}, f"domain 7, {NOBODY}"),
        ({"ROS_DISTRO": "humble"}, f"domain 7, {HERE}"),
    ],
)
def test_peers_on_other_machines_are_named_where_they_count(env: dict[str, str], expected: str) -> None:
    assert described(limited({**env, PEERS: "lab.local", "ROS_DOMAIN_ID": "7"})) == expected


def test_following_the_advice_has_the_promised_effect() -> None:
    for release, given, only, wanted in product(RELEASES, [None, *REACH], [None, "0", "1"], ["LOCALHOST", "SUBNET"]):
        env = environment(release, given, only)
        changes = dict(change.split("=") for change in advice(env, wanted).split(" and "))
        assert described(limited({**env, **changes})) == f"domain 0, {REACH[wanted]}", (env, wanted)


def test_sourcing_does_not_widen_the_reach() -> None:
    sourced = {RANGE: "SUBNET", LOCALHOST_ONLY: "0", "ROS_DISTRO": "jazzy"}
    assert unsourced(sourced, {}) == {"ROS_DISTRO": "jazzy"}
    assert unsourced(sourced, {RANGE: "OFF"}) == {"ROS_DISTRO": "jazzy", RANGE: "OFF"}


def environment(release: str | None, given: str | None, only: str | None) -> dict[str, str]:
    variables = {"ROS_DISTRO": release, RANGE: given, LOCALHOST_ONLY: only}
    return {name: value for name, value in variables.items() if value is not None}
