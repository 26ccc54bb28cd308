"""The joints that controllers themselves list in their parameter `joints` (rcl_interfaces, imported lazily; the node
is passed in)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from improv_core.outputs.ros.topic import Now

LIMIT = 2.0
"""Seconds to wait for the service of a node, when it is asked first, and then for its response."""
STRING_ARRAY = 9
"""The type of such a parameter: PARAMETER_STRING_ARRAY of rcl_interfaces/msg/ParameterType."""


@dataclass(slots=True)
class _Call:
    """A request to a controller's node; `ends` is the time until which its response is awaited."""

    client: Any
    ends: float
    answer: Any = None


class ControllerJoints:
    """Reads the joints of controllers. Nothing here blocks; the executor that spins `node` receives the responses."""

    def __init__(self, node: Any, now: Now) -> None:
        self._node = node
        self._now = now
        self._calls: dict[str, _Call] = {}
        self._joints: dict[str, tuple[str, ...]] = {}

    def ask(self, topic: str, *, again: bool) -> None:
        """Ask the controller that listens on a topic, or ask it `again`: another one may have taken its place."""
        before = self._calls.get(topic)
        if before and again:
            self._calls[topic] = _Call(before.client, self._now())
        elif not before:
            self._calls[topic] = _Call(self._client(topic), self._now() + LIMIT)

    def awaited(self, topic: str) -> bool:
        """Return whether the response about a topic may come soon. Call it repeatedly: it asks nodes as they appear."""
        call = self._calls[topic]
        if call.answer is None and call.client.service_is_ready():
            call.answer = call.client.call_async(call.client.srv_type.Request(names=["joints"]))
            call.ends = self._now() + LIMIT
        if call.answer is None or not call.answer.done():
            return self._now() < call.ends
        for value in () if call.answer.exception() else call.answer.result().values:
            if value.type == STRING_ARRAY:
                self._joints[topic] = tuple(value.string_array_value)
        return False

    def of(self, topic: str) -> Sequence[str]:
        """The joints of the controller that listens on a topic, in its order; none if they are unknown."""
        return self._joints.get(topic, ())

    def _client(self, topic: str) -> Any:
        from rcl_interfaces.srv import GetParameters

        # The topics of a controller are in the namespace of its node's name.
        return self._node.create_client(GetParameters, f"{topic.rpartition('/')[0]}/get_parameters")
