"""Calls to the services that move robots to their start poses (std_srvs, imported lazily; the node is passed in)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from improv_core.outputs.ros.subscriber_check import SETTLE
from improv_core.outputs.ros.topic import Now, RosTopic

LIMIT = 0.5
"""Seconds that beat 0 waits to find a service, and then for its response."""


@dataclass(slots=True)
class _Call:
    """A service to call, the robots it resets, and its progress. Until `ends`, it holds back beat 0."""

    service: str
    client: Any
    robots: list[str]
    topics: list[RosTopic]
    ends: float
    answer: Any = None
    done: bool = False

    def proceed(self, now: float) -> None:
        if self.answer is None and self.client.service_is_ready():
            self.answer = self.client.call_async(self.client.srv_type.Request())
            self.ends = now + LIMIT
        if not self.done and self.answer is not None and self.answer.done():
            self.done = True
            self.ends = now + SETTLE
            # turtlesim's `/reset` creates new turtles with new listeners.
            for topic in self.topics:
                topic.unsettle()

    def warning(self) -> str | None:
        robots = ", ".join(self.robots)
        if self.answer is None:
            return f"no node offers the service {self.service} (std_srvs/srv/Empty), so these were not reset: {robots}"
        return (
            None if self.done else f"the service {self.service} has not answered, so these may not be reset: {robots}"
        )


class Resets:
    """The calls of the latest restart. Nothing here blocks; the executor that spins `node` receives the responses."""

    def __init__(self, node: Any, now: Now) -> None:
        self._node = node
        self._now = now
        self._clients: dict[str, Any] = {}
        self._calls: list[_Call] = []

    def begin(self, services: Iterable[tuple[str, str, RosTopic]]) -> None:
        """Call each service in these (service, robot, topic) once. The robots must already have been stopped."""
        calls: dict[str, _Call] = {}
        for service, robot, topic in services:
            if service not in calls:
                calls[service] = _Call(service, self._client(service), [], [], self._now() + LIMIT)
            calls[service].robots.append(robot)
            calls[service].topics.append(topic)
        self._calls = list(calls.values())
        self.under_way()

    def under_way(self) -> bool:
        """Return whether beat 0 must still wait. Call it repeatedly: it calls services as they appear."""
        for call in self._calls:
            call.proceed(self._now())
        return any(self._now() < call.ends for call in self._calls)

    def warnings(self) -> Mapping[str, str]:
        """One line for each service that hasn't responded yet, under the first robot that it resets."""
        return {call.robots[0]: line for call in self._calls if (line := call.warning())}

    def _client(self, service: str) -> Any:
        if service not in self._clients:
            from std_srvs.srv import Empty

            self._clients[service] = self._node.create_client(Empty, service)
        return self._clients[service]
