"""A stage's process: threads read its standard input and write its output while it plays. Whatever ends it, it first
sends every robot zeros."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

from improv_core.ipc.arrivals import Arrival, End
from improv_core.ipc.priority_queue import UrgentQueue
from improv_core.plain import one_line
from improv_core.protocol.json_lines import own_output
from improv_core.protocol.limits import STOP_PIPE
from improv_core.protocol.messages import FromStage, Ready
from improv_core.protocol.output import Sink
from improv_core.protocol.page_messages import ForPages
from improv_core.safety.parent_heartbeat import Parent
from improv_core.safety.suspend import asleep
from improv_core.score.joints import JointMotion
from improv_core.score.motion import Twist
from improv_core.stage.loop import EARLY, Inbox
from improv_core.stage.stdio import Outbox, read_arrivals, read_stops, write_messages

SWITCH_INTERVAL = 0.0005
"""Seconds that a thread of ours may work while the player waits: a long score takes its reader a hundred times that."""

Tell = Callable[[FromStage], None]
Hear = Callable[[Arrival], None]


class Job(NamedTuple):
    """The work of a stage's process: `run` returns its exit code, `ready` is its first message, and `hand_to_pages`
    gets what it is sent for pages, on the thread that reads."""

    run: Callable[[Inbox, Parent], int]
    ready: Ready
    hand_to_pages: Callable[[ForPages], None] = lambda message: None


def perform(begin: Callable[[Tell, Hear], Job]) -> int:
    """Do what standard input requests until it ends. Returns exit code 1 after a failure, and 2 if `begin` raises.

    `begin` gets the functions that send the parent a message and that put an arrival into the inbox.
    """
    say = own_output()
    sys.setswitchinterval(SWITCH_INTERVAL)
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    outbox = Outbox()
    pipe = os.environ.pop(STOP_PIPE, None)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: inbox.put(End()))
    writer = threading.Thread(target=write_messages, args=(outbox, say), daemon=True)
    writer.start()
    try:
        job = begin(outbox.put, inbox.put)
    except Exception as error:  # whatever a sink's libraries raise, the one line about it must get out
        outbox.put({"type": "error", "message": one_line(error)})
        code = 2
    else:
        parent = Parent()
        if pipe:  # then only messages there show that the parent lives
            threading.Thread(target=read_stops, args=(int(pipe), inbox, parent), daemon=True).start()
        reading = inbox, None if pipe else parent, job.hand_to_pages
        threading.Thread(target=read_arrivals, args=reading, daemon=True).start()
        # A garbage collection over all imported modules would make commands late.
        gc.freeze()
        gc.set_threshold(50_000, 20, 100)
        outbox.put(job.ready)
        code = job.run(inbox, parent)
    outbox.put(None)
    writer.join(timeout=1)  # a parent that no longer reads must not keep us alive
    return code


class SystemClock:
    """The clocks of the machine."""

    now = staticmethod(time.monotonic)
    wall = staticmethod(time.time)
    asleep = staticmethod(asleep)

    def wait_until(self, now: float) -> None:
        while (left := now - time.monotonic()) > 0:
            if left > EARLY:
                time.sleep(left - EARLY)


def report_sent(sink: Sink, put: Tell) -> None:
    """Have a sink report every velocity it sends, also by itself; the time is taken just before."""
    send, send_joints = sink.send, sink.send_joints

    def send_and_tell(robot: str, twist: Twist, at: float) -> None:
        wall = time.time_ns()
        send(robot, twist, at)
        put({"type": "sent", "robot": robot, "twist": [twist.x, twist.y, twist.z, twist.yaw], "wall": wall})

    def send_joints_and_tell(robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0) -> None:
        wall = time.time_ns()
        send_joints(robot, joints, at, pace)
        told = {name: list(motion) for name, motion in joints.items()}
        put({"type": "sent_joints", "robot": robot, "joints": told, "wall": wall})

    sink.send = send_and_tell  # type: ignore[method-assign]
    sink.send_joints = send_joints_and_tell  # type: ignore[method-assign]
