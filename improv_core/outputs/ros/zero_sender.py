"""Sends pending zeros (safety/pending_zeros.py) again on ROS 2 topics."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any

from improv_core.outputs.cdr import twist_message
from improv_core.outputs.ros.standby.client import Standby
from improv_core.outputs.ros.subscriber_check import ZEROS
from improv_core.outputs.ros.topic import Now, RosTopic
from improv_core.safety.pending_zeros import PendingZero, TopicFacts, check, pending_zero
from improv_core.score.motion import STILL

MAX_CHECKS = 4
"""The most topics to check in one `retry`. With 100 topics on a busy machine, each took 0.3 to 0.6 ms."""
ZERO = twist_message(STILL)


class PendingZeros:
    """The topics whose listeners may not have received a zero. The standby also knows of them, and which robots move.
    ROS's `clock` stamps zeros, `others` names the other nodes that publish on a topic, and `tell` gets lines for
    people."""

    def __init__(
        self,
        standby: Standby,
        clock: Any,
        others: Callable[[RosTopic], Collection[str]],
        tell: Callable[[str], None],
        now: Now,
    ) -> None:
        self._standby = standby
        self._clock = clock
        self._others = others
        self._tell = tell
        self._now = now
        self._pending: dict[str, _Entry] = {}  # by topic, the one that was checked longest ago first

    def note_velocity(self, topic: RosTopic, frame: str) -> None:
        self._standby.note_velocity(topic.name, frame)
        self._pending.pop(topic.name, None)

    def note_zero(self, robot: str, topic: RosTopic, frame: str, zero: bytes = ZERO) -> None:
        moved = topic.name in self._standby.moving
        self._standby.note_zero(topic.name)
        now, entry = self._now(), self._pending.get(topic.name)
        if entry:
            entry.state = entry.state.sent(now)
        elif moved:
            state = pending_zero(now, topic.count_listeners(), topic.was_heard)
            self._pending[topic.name] = _Entry(robot, topic, frame, state, zero)

    def note_inherited(self, robot: str, topic: RosTopic, frame: str, zero: bytes = ZERO) -> None:
        """Note that a robot that an earlier stage may have moved is sent a zero."""
        self._standby.note_pending(topic.name, frame)
        state = pending_zero(self._now(), topic.count_listeners(), topic.was_heard, inherited=True)
        self._pending[topic.name] = _Entry(robot, topic, frame, state, zero)

    @property
    def due(self) -> float:
        """The time at which `retry` is due, in monotonic seconds."""
        return min((entry.state.due for entry in self._pending.values()), default=math.inf)

    def retry(self, now: float) -> None:
        """Send zeros that are due again, or find out that listeners have received them."""
        due = [name for name, entry in self._pending.items() if entry.state.due <= now]
        for name in due[:MAX_CHECKS]:
            entry = self._pending.pop(name)
            found = check(entry.state, now, self._facts(entry.topic))
            if found.pending:
                self._pending[name] = replace(entry, state=found.pending)
            else:
                self._standby.note_confirmed(name)
            for _ in range(ZEROS if found.asks else found.sends):
                entry.topic.publish(entry.zero, self._clock, entry.frame)
            if found.warns:
                self._tell(
                    f"{entry.robot} may still be moving: no listener on {name} has confirmed the stop; "
                    "look at the robot"
                )

    def _facts(self, topic: RosTopic) -> TopicFacts:
        confirmed = topic.has_confirmed()
        # Only then it matters, and it takes longer.
        confirms = confirmed and topic.confirms()
        return TopicFacts(topic.count_listeners(), confirms, confirmed, frozenset(self._others(topic)))


@dataclass(slots=True)
class _Entry:
    robot: str
    topic: RosTopic
    frame: str
    state: PendingZero
    zero: bytes
