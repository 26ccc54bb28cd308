"""The answer to a look at ROS 2's graph, as one line of JSON."""

from __future__ import annotations

from typing import TypedDict

from improv_core.protocol.fields import PoseJson

UNNAMED = "an unnamed node"
"""The name for a node that the graph shows before the node itself has announced its name."""


class Endpoint(TypedDict):
    """A publisher or a subscription: its node, the type of its messages, and its quality of service."""

    node: str
    type: str
    reliable: bool
    latched: bool
    """True if it is transient local."""


class Endpoints(TypedDict):
    """All endpoints of a topic."""

    listeners: list[Endpoint]
    publishers: list[Endpoint]
    age: float | None
    """The age of the newest pose when it came, in seconds by its stamp and our clock; None if none came."""
    gap: float
    """Seconds for which no pose came though some had come; 0 from sources that send one only after a movement."""
    pose: PoseJson | None
    """The latest pose."""
    battery: float | None
    """The charge of a battery, from 0 to 1."""


Graph = dict[str, Endpoints]
"""The endpoints by topic."""
