"""A stage's process: threads read and write while it plays. Whatever ends it, it first sends every robot zeros."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple, cast

from improv_core.ipc.arrivals import Arrival, DirectStop, End, OutputChannel, UrgentQueue
from improv_core.plain import one_line
from improv_core.protocol.commands import COMMANDS, Conduct, PageRequest, Stop
from improv_core.protocol.json_lines import own_output
from improv_core.protocol.limits import STOP_PIPE, STOP_SOCKETS
from improv_core.protocol.messages import VERSION, FromStage, Ready, Sent
from improv_core.protocol.output import BaseCommand, Sink
from improv_core.protocol.page_messages import ForPages
from improv_core.safety.heartbeat import Parent
from improv_core.safety.stage_stops import OBEYED, SIMULATOR, StageSocket
from improv_core.safety.stop_server import Answer
from improv_core.safety.stops import asleep
from improv_core.score.joints import JointMotion
from improv_core.stage.loop import EARLY, Inbox, OpenedOutput, run
from improv_core.stage.stdio import Outbox, put, read_arrivals, read_stops, write_messages

SWITCH_INTERVAL = 0.0005
"""Seconds that a thread of ours may work while the player waits: a long score takes its reader a hundred times that."""

Tell = Callable[[FromStage], None]
HearArrival = Callable[[Arrival], None]


class Job(NamedTuple):
    """The work of a stage's process: `run` returns its exit code, `ready` is its first message, and `hand_to_pages`
    gets what it is sent for pages, on the thread that reads."""

    run: Callable[[Inbox, Parent], int]
    ready: Ready
    hand_to_pages: Callable[[ForPages], None] = lambda message: None
    moves: bool = True
    """False if there are no robots that a stop would have to reach."""


def perform(begin: Callable[[Tell, HearArrival], Job], signaled: str = "", name: str = SIMULATOR) -> int:
    """Do what standard input requests until it ends. Returns exit code 1 after a failure, and 2 if `begin` raises.

    `begin` gets the functions that send the parent a message and that put an arrival into the inbox. `signaled` is the
    problem if a signal ends the process; without one, that is no failure. `name` is that of the stage, for its socket.
    """
    say = own_output()
    sys.setswitchinterval(SWITCH_INTERVAL)
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    outbox: Outbox = UrgentQueue()
    tell = partial(put, outbox)
    pipe, show = os.environ.pop(STOP_PIPE, None), os.environ.pop(STOP_SOCKETS, None)
    reached: StageSocket | None = None

    def report(message: FromStage) -> None:
        if reached and message["type"] == "transport":
            reached.hear(message)
        tell(message)

    def take(stop: Stop, answer: Answer) -> None:
        inbox.put_first(DirectStop(stop, lambda: answer(OBEYED)))

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: inbox.put(End(signaled)))
    writer = threading.Thread(target=write_messages, args=(outbox, say), daemon=True)
    writer.start()
    try:
        job = begin(report, inbox.put)
        if show and job.moves:
            reached = StageSocket(Path(show), name, take)
    except Exception as error:  # whatever a sink's libraries raise, the one line about it must get out
        tell({"type": "error", "message": one_line(error)})
        code = 2
    else:
        parent = Parent()
        if pipe:  # then only messages there show that the parent lives
            threading.Thread(target=read_stops, args=(int(pipe), inbox, parent, tell), daemon=True).start()
        reading = inbox, None if pipe else parent, job.hand_to_pages
        threading.Thread(target=read_arrivals, args=reading, daemon=True).start()
        # A garbage collection over all imported modules would make commands late.
        gc.freeze()
        gc.set_threshold(50_000, 20, 100)
        tell(job.ready)
        code = job.run(inbox, parent)
        if reached and code == 0:  # otherwise, robots may still move, and no other stage has taken them over
            reached.close()
    outbox.put(None)
    writer.join(timeout=1)  # a parent that no longer reads must not keep us alive
    return code


def play(open_sink: Callable[[OutputChannel], Sink], name: str, *, reports: bool) -> int:
    """Play what standard input requests until it ends, as the stage of this `name`. If it `reports`, it tells the
    parent each velocity that it sends. Returns exit code 1 after a failure, 2 if the output can't be used."""

    def begin(put: Tell, hear: HearArrival) -> Job:
        def ask(command: PageRequest) -> None:
            if COMMANDS[command["type"]].at_once:
                hear(cast(Conduct, command))  # now, even if the parent hangs, or gets nothing before we are ready
            put({"type": "request", "command": command})

        def tell_both(message: FromStage) -> None:
            # A speed that was set before the first score is no news: the parent would take it for the end of a score.
            if message["type"] != "transport" or message["generation"]:
                if message["type"] != "pong":  # that is only the parent's
                    sink.show(message)
                put(message)

        sink = open_sink(OutputChannel(hear, ask, lambda line: tell_both({"type": "warning", "message": line})))
        ready: Ready = {"type": "ready", "protocol": VERSION, "sink": sink.description, "real": True}
        opened = OpenedOutput(sink, tell_both, sink.announce)
        if reports:
            report_sent(sink, put)
        return Job(lambda inbox, parent: run(opened, inbox, SystemClock(), parent), ready)

    return perform(begin, name=name)


class SystemClock:
    """The clocks of the machine."""

    now = staticmethod(time.monotonic)
    wall = staticmethod(time.time)
    asleep = staticmethod(asleep)

    def wait_until(self, now: float) -> None:
        while (left := now - time.monotonic()) > 0:
            if left > EARLY:
                time.sleep(left - EARLY)


def report_sent(sink: Sink, put: Callable[[Sent], None], wall_at: Callable[[float], int] | None = None) -> None:
    """Have a sink report every velocity it sends, also by itself, and its Unix time in nanoseconds: that just before,
    or that of a time of the performance."""
    ready, send_joints = sink.ready, sink.send_joints

    def ready_and_told(commands: Sequence[BaseCommand]) -> Callable[[], None]:
        send = ready(commands)

        def send_and_tell() -> None:
            now = time.time_ns()
            send()
            for robot, twist, at in commands:
                told: Sent = {"type": "sent", "robot": robot, "wall": wall_at(at) if wall_at else now}
                put({**told, "twist": [twist.x, twist.y, twist.z, twist.yaw], **sink.sent_as(robot)})

        return send_and_tell

    def send_joints_and_tell(robot: str, joints: Mapping[str, JointMotion], at: float, *more: float) -> None:
        wall = wall_at(at) if wall_at else time.time_ns()
        send_joints(robot, joints, at, *more)
        told = {name: list(motion) for name, motion in joints.items()}
        put({"type": "sent", "robot": robot, "joints": told, "wall": wall})

    sink.ready = ready_and_told  # type: ignore[method-assign]
    sink.send_joints = send_joints_and_tell  # type: ignore[method-assign, assignment]
