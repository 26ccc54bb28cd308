"""Watches a stage that moves real robots, and stops them itself if the stage dies, is halted, or hangs.

A new stage would have to discover the robots first, which takes seconds; this process is matched with them already.

The stage starts it with its own interpreter, as `python …/improv_core/stage standby`. Standard library only (rclpy
imported lazily).
"""

from __future__ import annotations

import math
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from improv_core.outputs.cdr import numbers_message, stamped, twist_message
from improv_core.outputs.ros.subscriber_check import ZEROS
from improv_core.protocol.json_lines import Lines, own_output
from improv_core.protocol.standby_messages import FromStandby, ToStandby
from improv_core.safety.pending_zeros import LAST_ZEROS, LINGER, UNCONFIRMED, TopicFacts, check, pending_zero
from improv_core.score.motion import STILL

LOOK = 0.12
"""Seconds without a sign of life after which to check whether a stage that moves robots was halted: slightly longer
than the time between two signs of life, so that a healthy stage isn't checked."""
FIND = 0.02
"""Seconds between two searches for listeners of new publishers."""
FIND_LIMIT = 10.0
"""Seconds to search for them: robots may not be there at all."""
ALIVE_PERIOD = 0.1
"""Seconds between two signs of life while there is much to do."""
ZERO_PERIOD = 0.05
"""Seconds between two zeros."""
DISCOVERY_LIMIT = 3.0
"""Seconds to keep sending zeros on a topic without listeners: a standby as young as its stage may not have found the
robot."""


END_LIMIT = 2.0
"""Seconds that a stage may take to end after its last message."""


class ParentWatch:
    """Decides when a stage has to be replaced, from its messages and their times in seconds."""

    def __init__(self, now: float) -> None:
        self.moved: dict[str, str] = {}
        """The topics on which robots have moved since all last stood, with the frames of their velocities."""
        self.pending: dict[str, str] = {}
        """The topics whose robots may lack their zeros, with the same frames. Once the stage is gone, only we know."""
        self.ended = False
        """True after the stage's last message: all robots stand."""
        self._heard = self._looked = now
        self._hung = math.inf

    def take(self, message: ToStandby, now: float) -> None:
        """Take a message from the stage; those about publishers are ignored."""
        self._heard = now
        if message["type"] == "moves":
            self.moved[message["topic"]] = message["frame"]
            self.pending.pop(message["topic"], None)
        elif message["type"] == "stands":
            self.pending |= self.moved
            self.moved.clear()
        elif message["type"] == "pending":
            self.pending[message["topic"]] = message["frame"]
        elif message["type"] == "confirmed":
            for topics in (self.pending, self.moved):
                topics.pop(message["topic"], None)
        elif message["type"] == "end":
            self.ended = True
        if message["type"] == "moves" or message["type"] == "pulse":
            self._looked, self._hung = now, now + message["patience"]

    def is_silent(self, now: float) -> bool:
        """Return whether the stage may have been halted. Take all its messages before."""
        return now >= self._heard + LOOK

    def must_stop(self, now: float, gone: bool, halted: bool) -> bool:
        """Return whether robots move that the stage can't stop anymore, or whether it can't repeat their zeros. Take
        all its messages before. Pending zeros of a stage that is gone need no stop."""
        if now > self._looked + 2 * LOOK:
            self._hung += now - self._looked  # this process stalled, which says nothing about the stage
        self._looked = now
        fails = halted or (bool(self.moved) and (gone or now > self._hung))
        return fails and bool(self.moved or self.pending) and not self.ended


def main() -> int:
    """Watch the parent process until it ends; its messages come over standard input."""
    lines: Lines[ToStandby] = Lines()
    tell: Callable[[FromStandby], None] = own_output()
    stage = _Stage(os.getppid())
    publishers = _Publishers(sys.argv[1], sys.argv[2:])
    watch = ParentWatch(time.monotonic())
    tell({"type": "alive"})
    said = time.monotonic()
    while not watch.ended:
        gone = stage.wait(FIND if publishers.new else LOOK if watch.moved or watch.pending else None)
        now = time.monotonic()
        for topic, kind in publishers.found(now):
            tell({"type": "found", "topic": topic, "kind": kind})
        for message in lines.read():
            watch.take(message, now)
            publishers.take(message)
            if message["type"] == "pulse" or time.monotonic() > said + ALIVE_PERIOD:
                tell({"type": "alive"})
                said = time.monotonic()
        gone = gone or lines.ended
        if watch.must_stop(now, gone, watch.is_silent(now) and stage.is_halted()):
            if not gone:  # a stage that closed the pipe sends nothing anymore and may still have to report
                stage.kill()  # it could resume and keep sending
            publishers.stop(watch.moved)
        elif not gone:
            continue
        break
    if pending := {**watch.pending, **watch.moved}:
        publishers.send_zeros(pending)  # at once: before, their listeners would count as having confirmed everything
        stage.wait_for_end(END_LIMIT)  # otherwise its node would count as another one that moves the robots
        publishers.retry(pending)
    publishers.close()
    return 0


class _Stage:
    """The process that is watched."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._poll = select.poll()
        self._poll.register(0, select.POLLIN)
        self._fd = -1
        with suppress(AttributeError, OSError):  # Linux 5.3 and newer; elsewhere the end of standard input shows it
            self._fd = os.pidfd_open(pid)
            self._poll.register(self._fd, select.POLLIN)

    def wait(self, seconds: float | None) -> bool:
        """Wait for a message or the end. Returns whether the process has ended."""
        events = self._poll.poll(None if seconds is None else seconds * 1000)
        return any(fd == self._fd for fd, _ in events) or os.getppid() != self._pid

    def wait_for_end(self, seconds: float) -> None:
        """Wait until it has ended, no matter what it sends."""
        with suppress(KeyError):
            self._poll.unregister(0)
        self._poll.poll(seconds * 1000)

    def is_halted(self) -> bool:
        """Return whether it got SIGSTOP or is traced. False if there is no /proc."""
        try:
            stat = Path(f"/proc/{self._pid}/stat").read_bytes()
        except OSError:
            return False
        return stat[stat.rindex(b")") + 2 :][:1] in (b"T", b"t")

    def kill(self) -> None:
        if os.getppid() == self._pid:
            with suppress(ProcessLookupError):
                os.kill(self._pid, signal.SIGKILL)


class _Publishers:
    """Publishers like those of the stage, matched with the same listeners."""

    def __init__(self, node: str, arguments: Sequence[str]) -> None:
        from improv_core.outputs.ros.nodes import Nodes
        from improv_core.outputs.ros.topic import message_class

        # Nobody spins the node, so it offers no services; it doesn't log either.
        self._nodes = Nodes(node, arguments, start_parameter_services=False, enable_rosout=False)
        message_class("Twist")  # imported before the first robot waits for it
        self._made: dict[tuple[str, str], tuple[Any, Callable[[], None]]] = {}
        self._joints: dict[str, int] = {}  # the number of joints of the controllers on topics
        self._ahead = 0  # nanoseconds by which stamps are ahead of this machine's time
        self.new: dict[tuple[str, str], float] = {}
        """Publishers without a listener so far, each with the time until which to search."""

    def found(self, now: float) -> Iterator[tuple[str, str]]:
        """The topics and kinds of new publishers that have found a listener."""
        for key, until in list(self.new.items()):
            if found := self._made[key][0].get_subscription_count() > 0:
                yield key
            if found or now > until:
                del self.new[key]

    def take(self, message: ToStandby) -> None:
        if message["type"] == "publish":
            from improv_core.outputs.ros.topic import message_class

            topic, kind = message["topic"], message["kind"]
            self._made[topic, kind] = self._nodes.advertise(message_class(kind), topic, message["second"])
            self._joints[topic] = message["joints"]
            self.new[topic, kind] = time.monotonic() + FIND_LIMIT
        elif message["type"] == "pulse":
            self._ahead = message["ahead"]
        elif message["type"] == "withdraw":
            _, destroy = self._made.pop((message["topic"], message["kind"]))
            self.new.pop((message["topic"], message["kind"]), None)
            destroy()

    def stop(self, topics: Mapping[str, str]) -> None:
        """Send zeros on all these topics at once, in their frames, and longer on topics without a known listener.

        If one publisher fails, the others still send theirs.
        """
        left = {(topic, kind): LAST_ZEROS for topic, kind in self._made if topic in topics}
        end = time.monotonic() + DISCOVERY_LIMIT
        while left and time.monotonic() < end:
            for topic, kind in list(left):
                publisher, _ = self._made[topic, kind]
                with suppress(Exception):  # whatever rclpy raises
                    self._send_zero(publisher, topic, kind, topics[topic])
                    left[topic, kind] -= publisher.get_subscription_count() > 0
            left = {key: count for key, count in left.items() if count}
            time.sleep(ZERO_PERIOD)
        time.sleep(LINGER)

    def send_zeros(self, topics: Mapping[str, str], count: int = ZEROS) -> None:
        """Send zeros on these topics, in their frames: so many that DDS asks for a confirmation."""
        for topic, frame in topics.items():
            for kind, publisher in [*self._on(topic).items()] * count:
                with suppress(Exception):  # whatever rclpy raises: the others need their zeros
                    self._send_zero(publisher, topic, kind, frame)

    def retry(self, topics: Mapping[str, str]) -> None:
        """Send pending zeros on these topics, in their frames, until they are confirmed, or for `UNCONFIRMED`."""
        now = time.monotonic()
        pending = {topic: pending_zero(now, self._facts(topic).listeners, listened=True) for topic in topics}
        end = now + UNCONFIRMED
        while pending and now < end:
            for topic in [topic for topic, each in pending.items() if each.due <= now]:
                found = check(pending.pop(topic), now, self._facts(topic))
                if found.sends:
                    self.send_zeros({topic: topics[topic]}, ZEROS if found.asks else 1)
                if found.pending:
                    pending[topic] = found.pending
            time.sleep(ZERO_PERIOD)
            now = time.monotonic()

    def _on(self, topic: str) -> dict[str, Any]:
        """The publishers on a topic, by kind."""
        return {kind: publisher for (name, kind), (publisher, _) in self._made.items() if name == topic}

    def _facts(self, topic: str) -> TopicFacts:
        from improv_core.outputs.ros.nodes import is_harmless
        from improv_core.outputs.ros.topic import confirms, has_confirmed

        node, made = self._nodes.first, self._on(topic)
        infos = node.get_publishers_info_by_topic(topic)
        names = {f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in infos} - {*self._nodes.names}
        return TopicFacts(
            sum(publisher.get_subscription_count() for publisher in made.values()),
            confirms(node, topic, made),
            all(map(has_confirmed, made.values())),
            frozenset(name for name in names if not is_harmless(name)),
        )

    def _send_zero(self, publisher: Any, topic: str, kind: str, frame: str) -> None:
        if joints := self._joints[topic]:
            publisher.publish(numbers_message([0.0] * joints))
            return
        zero, now = twist_message(STILL), time.time_ns() + self._ahead
        publisher.publish(stamped(zero, now, frame) if kind == "TwistStamped" else zero)

    def close(self) -> None:
        self._nodes.close()
