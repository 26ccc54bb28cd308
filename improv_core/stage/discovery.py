"""Which robots ROS 2 may reach: what the environment says of it, in each release."""

from __future__ import annotations

DISCOVERY = "ROS_AUTOMATIC_DISCOVERY_RANGE"
LOCALHOST_ONLY = "ROS_LOCALHOST_ONLY"
RELEASES_BEFORE_RANGES = ("foxy", "galactic", "humble")
"""They know only LOCALHOST_ONLY."""
RELEASES_OF_BOTH = ("iron", "jazzy")
"""In these LOCALHOST_ONLY goes before the range where it is 1, with a warning (rcl#1069); later ones ignore it."""
REACH = {
    "LOCALHOST": "this machine only",
    "SUBNET": "the whole subnet",
    "OFF": "no discovery",
    "SYSTEM_DEFAULT": "the system's own reach",
}
