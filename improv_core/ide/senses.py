"""Describe senses: their meanings and their sources."""

from __future__ import annotations

import math
from collections.abc import Mapping

from improv_core.robots.config import Robots
from improv_core.score.senses import BUMP, CUE, NEAR, Key, OscName, Topic

_ABOUT: Mapping[str, str] = {
    BUMP: "The robot touches something.",
    NEAR: "Something is ahead of the robot, closer than the `near` distance of its profile.",
    CUE: "Somebody gives the cue. It is true for an instant only.",
}
_SOURCES: Mapping[str, str] = {
    BUMP: "in the simulator: its collisions; in ROS 2: declare it in improv.toml",
    NEAR: "in the simulator: things in the way; in ROS 2: declare it in improv.toml",
    CUE: "key c, the button on the page, or a command of the editor",
}


def about(name: str) -> str:
    """Return in words when a sense is true."""
    return _ABOUT.get(name, "A sense that improv.toml declares.")


def source(robots: Robots, name: str) -> str:
    """Describe the source of a sense: `topic scan (sensor_msgs/LaserScan) below 0.5, -30° to 30°`."""
    declared = robots.senses.get(name)
    if isinstance(declared, Key):
        return f"key {declared.key}, while it is held on the page"
    if isinstance(declared, OscName):
        return f"OSC messages /improv/sense {declared.osc}"
    if not isinstance(declared, Topic):
        return _SOURCES[name]
    limit = f" below {declared.below:g}" if declared.below is not None else ""
    limit = f" above {declared.above:g}" if declared.above is not None else limit
    start, end = (round(math.degrees(angle), 1) for angle in (declared.start, declared.end))
    sector = f", {start:g}° to {end:g}°" if (start, end) != (-180, 180) else ""
    button = f", button {declared.button}" if declared.button is not None else ""
    return f"topic {declared.topic} ({declared.message}){limit}{sector}{button}"
