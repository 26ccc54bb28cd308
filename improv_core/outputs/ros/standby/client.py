"""The stage's side of the standby process (see process.py), which stops robots if the stage dies, and the rules by
which that process counts as lost."""

from __future__ import annotations

import json
import math
import os
import queue
import threading
import time
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress

from improv_core.ipc.child import Child, Policy
from improv_core.outputs.ros.discovery import limited
from improv_core.outputs.ros.nodes import STANDBY, node_name, without_name
from improv_core.protocol.limits import HANG_LIMIT, LOADING_LIMIT, helper_command
from improv_core.protocol.standby_messages import FromStandby, Publish, ToStandby

PULSE_PERIOD = 0.1
"""Seconds between two signs of life while robots move."""
PATIENCE = HANG_LIMIT + PULSE_PERIOD
"""Seconds without a sign of life after which the stage counts as hung. The parent notices first and reports it."""
AGAIN = 0.5
"""Seconds before a standby that failed to start is replaced again: it must not keep the machine busy."""
FIND_LIMIT = 3.0
"""Seconds that beat 0 waits for it to find the robots: discovery took up to 2.64 s on a quiet machine."""
ANSWER_LIMIT = 0.5
"""Seconds within which a standby answers a pulse while robots move; otherwise it is replaced."""
START_LIMIT = 5.0
"""Seconds within which a new standby sends its first message, on a quiet machine after half a second; and within which
one answers while robots stand: until then it may be creating publishers, which takes long on a busy machine."""
READY_LIMIT = 5.0
"""Seconds that robots may move without a standby that is ready: discovery alone took up to 3.3 s."""
STALL = 0.3
"""Seconds between two calls of `note_time` that prove that this process stalled, and nothing about the standby."""
POLICY = Policy(2.0, leads=True, waits=False, pipe_size=1 << 20)
"""It survives the stage. Messages about 1,000 robots don't fit into a usual pipe."""


def start_standby(discovery: str | None, arguments: Sequence[str], wanted: bool) -> Standby:
    """Start the standby of this process, which may reach the same robots: this sets the range in our environment.

    It takes as long to load as the modules of the stage, so it starts before these are imported.
    """
    os.environ.update(limited(os.environ, discovery))
    return Standby(node_name() + STANDBY, without_name(arguments)[1], time.monotonic, wanted)


class Standby:
    """Starts the standby, tells it the topics and which robots move, and replaces it if it is lost.

    The standby sends zeros if the stage dies. It publishes with the same arguments of ROS (`--ros-args …`) as the
    stage, so its topics are remapped alike. Nothing waits for it, except for its first start. A standby that is lost is
    replaced on another thread, and `problem` says so. If none is ready for too long, `alarm` gets a line that says that
    robots must not move on. Apart from that thread, use this from one thread only.
    """

    def __init__(
        self,
        node: str,
        arguments: Sequence[str],
        clock: Callable[[], float],
        wanted: bool,
        alarm: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._command = helper_command("outputs.ros.standby.process", node, *arguments)
        self._clock = clock
        self.wanted = wanted
        """True if there is to be a standby; one that is lost is replaced."""
        self.alarm = alarm
        self.time: Callable[[], int] = time.time_ns
        """The time of the stage's stamps, in nanoseconds."""
        self.problem: str | None = None
        """The latest problem with the standby, in one line."""
        self._publishers: dict[tuple[str, str], tuple[Publish, Callable[[], int]]] = {}  # by topic and kind
        self.moving: dict[str, str] = {}
        """The topics on which robots were sent a velocity after the last zero, and the frames of velocities."""
        self._pending: dict[str, str] = {}  # the same for robots that may not have received their zeros
        self._pulse = 0.0  # when the next sign of life is due
        self._monitor = StandbyMonitor(clock())
        self._found: set[tuple[str, str]] = set()  # publishers for which it has found a listener
        self._awaited_until = -math.inf
        self._has_spoken = False
        self._closing = threading.Event()
        self._new: queue.SimpleQueue[Child | OSError] = queue.SimpleQueue()
        self._starting: threading.Thread | None = None
        self._child = Child(self._command, POLICY) if wanted else None

    @property
    def works(self) -> bool:
        """True while there is a standby, as far as is known."""
        return self._child is not None

    def wait(self) -> None:
        """Wait until it has started, because that takes processor time that the robots will need."""
        if self._child:
            self._child.speaks(START_LIMIT)

    def is_ready(self, topics: Collection[str]) -> bool:
        """Return whether it has found a listener wherever we have on these topics, or isn't wanted."""
        if not self.wanted:
            return True
        if not self._child or not self._has_spoken:
            return False
        unfound = self._publishers.keys() - self._found
        return not any(key[0] in topics and self._publishers[key][1]() > 0 for key in unfound)

    def await_listeners(self) -> None:
        """Have beat 0 wait for a few seconds until it `is_ready`, from now on."""
        self._awaited_until = self._clock() + FIND_LIMIT

    def under_way(self, topics: Collection[str]) -> bool:
        """Return whether beat 0 must still wait until it could stop robots on these topics."""
        if self._clock() >= self._awaited_until:
            return False
        self.look()
        return not self.is_ready(topics)

    def renew(self) -> None:
        """Check that the standby is alive, because a score is about to begin."""
        if self.is_ready(()):
            self.problem = None
        self._ask(LOADING_LIMIT)

    def look(self) -> None:
        """Read the standby's messages, replace it if it is lost, and raise the alarm while robots move without it."""
        if not self.wanted:
            return
        now = self._clock()
        self._adopt(now)
        ended = not self._hear()
        self._monitor.note_time(now)
        if self._child and (ended or self._monitor.is_lost()):
            self._replace("has ended" if ended else "does not answer")
        if self._monitor.must_stop(bool(self.moving), self.is_ready(self.moving)):
            self.alarm(
                f"no standby process was ready to stop the robots for {READY_LIMIT:g} s, so all were stopped: "
                "play again, or turn off `ros.standby`"
            )

    def publish(self, topic: str, kind: str, second: bool, listeners: Callable[[], int], joints: int = 0) -> None:
        """Note that the stage has created a publisher of a message type on a topic, on its second node or not.
        `listeners` counts those that it has found, and `joints` is the number of joints of a velocity controller
        there."""
        message: Publish = {"type": "publish", "topic": topic, "kind": kind, "second": second, "joints": joints}
        self._publishers[topic, kind] = message, listeners
        self._found.discard((topic, kind))
        self._tell(message)

    def withdraw(self, topic: str, kind: str) -> None:
        del self._publishers[topic, kind]
        self._tell({"type": "withdraw", "topic": topic, "kind": kind})

    def note_velocity(self, topic: str, frame: str) -> None:
        """Note that the robot on a topic is about to get a velocity, in this frame."""
        if self.moving.get(topic) != frame:
            self.moving[topic] = frame
            self._pending.pop(topic, None)
            self._tell({"type": "moves", "topic": topic, "frame": frame, "patience": PATIENCE})

    def note_zero(self, topic: str) -> None:
        """Count the robot on a topic as stopped, and its zero as pending."""
        if topic in self.moving:
            self._pending[topic] = self.moving.pop(topic)
            if not self.moving:
                self._tell({"type": "stands"})

    def note_pending(self, topic: str, frame: str) -> None:
        """Note that the robot on a topic gets a zero because an earlier stage may have moved it."""
        self._pending[topic] = frame
        self._tell({"type": "pending", "topic": topic, "frame": frame})

    def note_confirmed(self, topic: str) -> None:
        """Note that a topic needs no more zeros, usually because its robot has confirmed them."""
        self._pending.pop(topic, None)
        self._tell({"type": "confirmed", "topic": topic})

    def live(self) -> None:
        """Send a sign of life, at most once per `PULSE_PERIOD`."""
        if self.moving and self._clock() >= self._pulse:
            self._ask(PATIENCE)

    def close(self) -> None:
        """End the process. If robots still move because the stage couldn't stop them, it tries that first. It stays for
        a while if robots may not have received their zeros, but nobody waits for that."""
        self._closing.set()
        if self._starting:
            self._starting.join(POLICY.end)
            self._adopt(self._clock())
        if not self.moving:
            self._tell({"type": "end"})
        if self._child and self._pending:
            self._child.close_input()
        elif self._child:
            self._child.end()

    def _ask(self, patience: float) -> None:
        """Send a sign of life, request one, and check for replies to earlier ones."""
        self._tell({"type": "pulse", "patience": patience, "ahead": self.time() - time.time_ns()})
        now = self._clock()
        self._pulse = now + PULSE_PERIOD
        self.look()
        self._monitor.note_pulse(now, bool(self.moving))

    def _tell(self, message: ToStandby) -> None:
        if self._child:
            self._child.write(json.dumps(message).encode() + b"\n")  # a standby that doesn't read shows by its silence

    def _hear(self) -> bool:
        """Read its messages. Returns whether more may come."""
        with suppress(EOFError):
            while self._child and (lines := self._child.read(0.0)):
                for line in lines:
                    self._take(line)
            return True
        return False

    def _take(self, line: bytes) -> None:
        with suppress(ValueError, LookupError, TypeError):  # the stage must not fail because of it
            message: FromStandby = json.loads(line)
            if message["type"] == "found":
                self._found.add((message["topic"], message["kind"]))
            self._has_spoken = True
            self._monitor.note_message()

    def _adopt(self, now: float) -> None:
        """Use the process that replaces a lost one, and send it all that the lost process knew."""
        if self._child or self._new.empty():
            return
        new = self._new.get()
        if isinstance(new, OSError):
            self._replace(f"can't start ({new})")
            return
        self._child = new
        self._monitor.note_start(now)
        for message, _ in self._publishers.values():
            self._tell(message)
        for topic, frame in self.moving.items():
            self._tell({"type": "moves", "topic": topic, "frame": frame, "patience": PATIENCE})
        for topic, frame in self._pending.items():
            self._tell({"type": "pending", "topic": topic, "frame": frame})

    def _replace(self, what: str) -> None:
        """Kill the process, which could wake up again, and start another one on a thread: nothing waits for it."""
        again = bool(self.problem) and not self._has_spoken  # the previous one failed too
        self.problem = f"the standby process {what}: another one starts"
        old, self._child = self._child, None
        self._found.clear()
        self._has_spoken = False
        arguments = old, AGAIN if again else 0.0
        self._starting = threading.Thread(target=self._start_another, args=arguments, daemon=True)
        self._starting.start()

    def _start_another(self, old: Child | None, after: float) -> None:
        if old:
            old.kill()
            old.end()
        if self._closing.wait(after):
            return
        try:
            self._new.put(Child(self._command, POLICY))
        except OSError as error:
            self._new.put(error)


class StandbyMonitor:
    """The facts that decide whether a standby is lost, and whether robots have moved for too long without one. It never
    reads a clock: call `note_time` before each decision. Times are in seconds."""

    def __init__(self, now: float) -> None:
        self._looked = now
        self._lacking = math.inf  # the time since which robots move without a standby that is ready
        self._due = math.inf  # the time at which the standby counts as lost, unless it sends something before
        self.note_start(now)

    def note_start(self, now: float) -> None:
        self._due, self._starts = now + START_LIMIT, True

    def note_pulse(self, now: float, moving: bool) -> None:
        """Note that the standby was sent a pulse, and whether robots move."""
        if not self._starts:
            self._due = min(self._due, now + (ANSWER_LIMIT if moving else START_LIMIT))

    def note_message(self) -> None:
        self._due, self._starts = math.inf, False

    def note_time(self, now: float) -> None:
        """Note that everything that the standby has sent until now has been read."""
        if now > self._looked + STALL:
            self._due += now - self._looked
        self._looked = now

    def is_lost(self) -> bool:
        return self._looked >= self._due

    def must_stop(self, moving: bool, ready: bool) -> bool:
        """Return whether robots have to be stopped, from whether they move and whether a standby could stop them."""
        if not moving or ready:
            self._lacking = math.inf
            return False
        self._lacking = min(self._lacking, self._looked)
        if self._looked < self._lacking + READY_LIMIT:
            return False
        self._lacking = self._looked
        return True
