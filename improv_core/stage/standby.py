"""Watches a stage that moves real robots, and stops them itself if the stage dies, is halted or hangs.

A new stage would have to discover the robots first, which takes seconds; this process is matched with them already.
Started by the stage, with its own interpreter, as `python …/improv_core/stage/standby.py`. Standard library only
(rclpy imported lazily).
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

if __name__ == "__main__":
    # As in __main__.py: our modules must not hide others of the same name, nor any of ROS's.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.append(str(here.parent.parent))

from improv_core.score.motion import STILL
from improv_core.stage.lines import Lines
from improv_core.stage.protocol import ToStandby
from improv_core.stage.setpoints import LAST_ZEROS, LINGER
from improv_core.stage.sinks.cdr import frame_field, stamped, twist_message

LOOK = 0.12
"""Seconds without a sign of life after which to look whether a stage that moves robots was halted: a little more than
there are between two of them, so that a stage that is well is not looked at."""
FIND = 0.02
"""Seconds between two looks whether listeners of new publishers have been found."""
ZERO_PERIOD = 0.05
"""Seconds between two zeros."""
DISCOVERY_LIMIT = 3.0
"""Seconds to keep sending zeros where nobody listens: a standby as young as its stage may not have found the robot."""


class Watch:
    """Decides when a stage has to be replaced, from its messages and the times (seconds) at which they came."""

    def __init__(self, now: float) -> None:
        self.moved: dict[str, str] = {}
        """The topics on which robots were told to move since all last stood, and the frames of their velocities."""
        self.ended = False
        """Whether the stage has said goodbye: all robots stand."""
        self._looked = now
        self._hung = math.inf

    def take(self, message: ToStandby, now: float) -> None:
        """Take a message of the stage's; those about publishers are not for us."""
        if message["type"] == "moves":
            self.moved[message["topic"]] = message["frame"]
        elif message["type"] == "stands":
            self.moved.clear()
        elif message["type"] == "end":
            self.ended = True
        if message["type"] == "moves" or message["type"] == "pulse":
            self._looked, self._hung = now, now + message["patience"]

    def must_stop(self, now: float, gone: bool, halted: bool) -> bool:
        """Whether robots move that the stage can no longer stop; all that it has said has been taken before."""
        if now > self._looked + 2 * LOOK:
            self._hung += now - self._looked  # we ourselves stood still, which says nothing of the stage
        self._looked = now
        return bool(self.moved) and not self.ended and (gone or halted or now > self._hung)


def main() -> int:
    """Watch the process that has started us, until it ends; what it says comes over standard input."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the end of our input ends us
    stage = _Stage(os.getppid())
    publishers = _Publishers(sys.argv[1], sys.argv[2:])
    watch = Watch(time.monotonic())
    lines: Lines[ToStandby] = Lines()
    os.write(1, b"ready\n")
    while not watch.ended:
        gone, silent = stage.wait(FIND if publishers.new else LOOK if watch.moved else None)
        now = time.monotonic()
        with suppress(OSError):  # the stage is gone, which is seen below
            for topic in publishers.found(now):
                os.write(1, topic.encode() + b"\n")
        for message in lines.read():
            watch.take(message, now)
            publishers.take(message)
        gone = gone or lines.ended
        if watch.must_stop(now, gone, silent and stage.is_halted()):
            if not gone:  # one that has closed our input sends nothing any more, and may have last words
                stage.kill()  # it could come back and continue to send
            publishers.stop(watch.moved)
        elif not gone:
            continue
        break
    publishers.close()
    return 0


class _Stage:
    """The process that is watched."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._poll = select.poll()
        self._poll.register(0, select.POLLIN)
        self._fd = -1
        with suppress(AttributeError, OSError):  # Linux 5.3 and newer; elsewhere the end of our input tells
            self._fd = os.pidfd_open(pid)
            self._poll.register(self._fd, select.POLLIN)

    def wait(self, seconds: float | None) -> tuple[bool, bool]:
        """Until it says something or ends: whether it has ended, and whether nothing came in time."""
        events = self._poll.poll(None if seconds is None else seconds * 1000)
        return any(fd == self._fd for fd, _ in events) or os.getppid() != self._pid, not events

    def is_halted(self) -> bool:
        """Whether it was sent SIGSTOP, or is traced. False if there is no /proc."""
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
    """Publishers like those of the stage, each matched with the same listeners."""

    def __init__(self, node: str, arguments: Sequence[str]) -> None:
        from improv_core.stage.sinks.ros_nodes import Nodes

        # Nobody spins the node, so it offers no services; nor does it log.
        self._nodes = Nodes(node, arguments, start_parameter_services=False, enable_rosout=False)
        self._made: dict[tuple[str, str], tuple[Any, Callable[[], None]]] = {}
        self.new: dict[tuple[str, str], float] = {}
        """Publishers that have found no listener yet, and until when to look."""

    def found(self, now: float) -> Iterator[str]:
        """The topics of new publishers that have found a listener."""
        for key, until in list(self.new.items()):
            if found := self._made[key][0].get_subscription_count() > 0:
                yield key[0]
            if found or now > until:
                del self.new[key]

    def take(self, message: ToStandby) -> None:
        if message["type"] == "publish":
            import geometry_msgs.msg

            topic, kind = message["topic"], message["kind"]
            made = self._nodes.advertise(getattr(geometry_msgs.msg, kind), topic, message["second"])
            self._made[topic, kind] = made
            self.new[topic, kind] = time.monotonic() + DISCOVERY_LIMIT
        elif message["type"] == "withdraw":
            _, destroy = self._made.pop((message["topic"], message["kind"]))
            self.new.pop((message["topic"], message["kind"]), None)
            destroy()

    def stop(self, topics: Mapping[str, str]) -> None:
        """Send zeros on these topics, in their frames, to all at once, and longer on those without a known listener.

        A publisher that fails does not keep the others from it.
        """
        left = {(topic, kind): LAST_ZEROS for topic, kind in self._made if topic in topics}
        zero, clock = twist_message(STILL), self._nodes.first.get_clock()
        end = time.monotonic() + DISCOVERY_LIMIT
        while left and time.monotonic() < end:
            for topic, kind in list(left):
                publisher, _ = self._made[topic, kind]
                with suppress(Exception):  # whatever rclpy raises
                    frame, now = frame_field(topics[topic]), clock.now().nanoseconds
                    publisher.publish(stamped(zero, now, frame) if kind == "TwistStamped" else zero)
                    left[topic, kind] -= publisher.get_subscription_count() > 0
            left = {key: count for key, count in left.items() if count}
            time.sleep(ZERO_PERIOD)
        time.sleep(LINGER)

    def close(self) -> None:
        self._nodes.close()


if __name__ == "__main__":
    sys.exit(main())
