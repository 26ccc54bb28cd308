"""Sends zeros that are owed (safety/pending_zeros.py) on ROS 2 topics."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

from improv_core.outputs.cdr import frame_field, twist_message
from improv_core.outputs.ros.topic import Now, RosTopic
from improv_core.safety.pending_zeros import Owed, TopicFacts, look, owe
from improv_core.score.motion import STILL

MOST_LOOKS = 4
"""How many topics to look at between two other things. With 100 topics on a busy machine, each took 0.3 to 0.6 ms."""
ZERO = twist_message(STILL)


class OwedZeros:
    """The topics on which robots were told to stop and may not have heard it. `others` names the other nodes that
    publish on a topic, `paid` gets topics on which zeros are no longer owed, and `tell` lines for people."""

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
        self._moved: set[str] = set()  # topics on which robots were told to move since they were last owed a zero
        self._debts: dict[str, _Debt] = {}  # by topic, the one that was looked at longest ago first

    def moves(self, topic: RosTopic) -> None:
        """Note that a robot is told to move."""
        self._moved.add(topic.name)
        self._debts.pop(topic.name, None)

    def stands(self, robot: str, topic: RosTopic, frame: str, zero: bytes = ZERO) -> None:
        """Note that a robot was told to stop, by this message."""
        now, debt = self._now(), self._debts.get(topic.name)
        if debt:
            debt.owed = debt.owed.sent(now)
        elif topic.name in self._moved:
            self._moved.discard(topic.name)
            owed = owe(now, topic.count_listeners(), topic.was_heard)
            self._debts[topic.name] = _Debt(robot, topic, frame, owed, zero)

    def inherits(self, robot: str, topic: RosTopic, frame: str, zero: bytes = ZERO) -> None:
        """Note that a robot that an earlier stage may have moved is told to stop."""
        owed = owe(self._now(), topic.count_listeners(), topic.was_heard, inherited=True)
        self._debts[topic.name] = _Debt(robot, topic, frame, owed, zero)

    @property
    def due(self) -> float:
        """When `pay` is due, in monotonic seconds."""
        return min((debt.owed.due for debt in self._debts.values()), default=math.inf)

    def pay(self, now: float) -> None:
        """Look at what is due: send zeros again, or find out that they were heard."""
        due = [name for name, debt in self._debts.items() if debt.owed.due <= now]
        for name in due[:MOST_LOOKS]:
            debt = self._debts.pop(name)
            found = look(debt.owed, now, self._facts(debt.topic))
            if found.owed:
                self._debts[name] = replace(debt, owed=found.owed)
            else:
                self._paid(name)
            if found.sends:
                self._send(debt.topic, debt.zero, frame_field(debt.frame))
            if found.tells:
                self._tell(
                    f"{debt.robot} may still be moving: nothing on {name} has confirmed that it was told to stop; "
                    "look at the robot"
                )

    def _facts(self, topic: RosTopic) -> TopicFacts:
        confirmed = topic.has_confirmed()
        # Only then it matters, and it takes longer.
        confirms = confirmed and topic.confirms()
        return TopicFacts(topic.count_listeners(), confirms, confirmed, frozenset(self._others(topic)))


@dataclass(slots=True)
class _Debt:
    robot: str
    topic: RosTopic
    frame: str
    owed: Owed
    zero: bytes
