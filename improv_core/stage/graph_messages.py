"""What a look at ROS 2's graph answers, as one line of JSON."""

from __future__ import annotations

from typing import TypedDict

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


Graph = dict[str, Endpoints]
"""By topic."""
