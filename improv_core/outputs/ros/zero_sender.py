"""Sends pending zeros (safety/pending_zeros.py) on ROS 2 topics."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

from improv_core.outputs.cdr import frame_field, twist_message
from improv_core.outputs.ros.topic import Now, RosTopic
from improv_core.safety.pending_zeros import Owed, TopicFacts, look, owe
from improv_core.score.motion import STILL

MOST_LOOKS = 4
"""The most topics to look at per call. With 100 topics on a busy machine, each took 0.3 to 0.6 ms."""
ZERO = twist_message(STILL)


class OwedZeros:
    """The topics on which robots may not have received their zeros. `others` names the other nodes that publish on a
    topic, `paid` gets the topics that need no more zeros, and `tell` gets lines for people."""

    def __init__(
        self,
        send: Callable[[RosTopic, bytes, bytes], None],
        others: Callable[[RosTopic], Collection[str]],
        paid: Callable[[str], None],
        tell: Callable[[str], None],
        now: Now,
    ) -> None:
        self._send = send
        self._others = others
        self._paid = paid
        self._tell = tell
        self._now = now
        self._moved: set[str] = set()  # topics on which robots have moved since their latest pending zero
        self._pending: dict[str, _PendingZero] = {}  # by topic, the longest unseen first

    def moves(self, topic: RosTopic) -> None:
        """Note that a robot gets a velocity."""
        self._moved.add(topic.name)
        self._pending.pop(topic.name, None)

    def stands(self, robot: str, topic: RosTopic, frame: str, zero: bytes = ZERO) -> None:
        """Note that a robot got this zero."""
        now, pending = self._now(), self._pending.get(topic.name)
        if pending:
            pending.owed = pending.owed.sent(now)
        elif topic.name in self._moved:
            self._moved.discard(topic.name)
            owed = owe(now, topic.count_listeners(), topic.was_heard)
            self._pending[topic.name] = _PendingZero(robot, topic, frame, owed, zero)

    def inherits(self, robot: str, topic: RosTopic, frame: str, zero: bytes = ZERO) -> None:
        """Note that a robot gets a zero because an earlier stage may have moved it."""
        owed = owe(self._now(), topic.count_listeners(), topic.was_heard, inherited=True)
        self._pending[topic.name] = _PendingZero(robot, topic, frame, owed, zero)

    @property
    def due(self) -> float:
        """The next time at which `pay` is due, in monotonic seconds."""
        return min((pending.owed.due for pending in self._pending.values()), default=math.inf)

    def pay(self, now: float) -> None:
        """Look at the topics that are due: send zeros again, or drop those that were confirmed."""
        due = [name for name, pending in self._pending.items() if pending.owed.due <= now]
        for name in due[:MOST_LOOKS]:
            pending = self._pending.pop(name)
            found = look(pending.owed, now, self._facts(pending.topic))
            if found.owed:
                self._pending[name] = replace(pending, owed=found.owed)
            else:
                self._paid(name)
            if found.sends:
                self._send(pending.topic, pending.zero, frame_field(pending.frame))
            if found.tells:
                self._tell(
                    f"{pending.robot} may still be moving: no listener on {name} has confirmed the stop; "
                    "look at the robot"
                )

    def _facts(self, topic: RosTopic) -> TopicFacts:
        confirmed = topic.has_confirmed()
        # Only then it matters, and it takes longer.
        confirms = confirmed and topic.confirms()
        return TopicFacts(topic.count_listeners(), confirms, confirmed, frozenset(self._others(topic)))


@dataclass(slots=True)
class _PendingZero:
    robot: str
    topic: RosTopic
    frame: str
    owed: Owed
    zero: bytes
