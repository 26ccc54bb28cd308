"""What a look at ROS 2's graph answers, as one line of JSON."""

from __future__ import annotations

from typing import TypedDict

from improv_core.protocol.fields import PoseJson

UNNAMED = "an unnamed node"
"""The node of an endpoint that the graph shows, while nothing has come that the node says of itself."""


class Endpoint(TypedDict):
    """A publisher or a subscription: its node, the type of its messages, and its quality of service."""

    node: str
    type: str
    reliable: bool
    latched: bool
    """Whether it is transient local."""


class Endpoints(TypedDict):
    """All of a topic."""

    listeners: list[Endpoint]
    publishers: list[Endpoint]
    age: float | None
    """How old the newest pose was when it came, in seconds by its stamp and our clock; None if none came."""
    gap: float
    """Seconds for which no pose came though some had come; 0 from sources that send one only after a movement."""
    pose: PoseJson | None
    """The latest pose."""
    battery: float | None
    """How full a battery is, from 0 to 1."""


Graph = dict[str, Endpoints]
"""By topic."""
