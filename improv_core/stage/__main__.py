"""The stage's process: JSON lines in, velocities out. Whatever ends it, it first sends every robot zeros.

Started as `python …/improv_core/stage`, perhaps by ROS's interpreter, in which our package is not installed. Its own
helper processes, and a look at ROS's graph, begin here too, with a name.
"""

from __future__ import annotations

import argparse
import errno
import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import cast

if __name__ == "__main__":
    # Python puts the folder it runs first on the path, where our modules would hide others of the same name. The folder
    # of our package goes last, so that it hides none of ROS's; but first, the package is found there, because another
    # version of it may be installed.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.insert(0, str(here.parent.parent))
    import_module("improv_core")
    sys.path.append(sys.path.pop(0))
    helpers = {
        "standby": "outputs.ros.standby.process",
        "reader": "outputs.ros.sensors.process",
        "publisher": "outputs.ros.publisher.process",
        "graph": "outputs.ros.graph",
        **{name: f"music.{name}" for name in ("osc", "midi", "link")},
    }
    if module := helpers.get(sys.argv[1] if sys.argv[1:] else ""):
        del sys.argv[1]
        sys.exit(import_module(f"improv_core.{module}").main())

from improv_core.ipc.arrivals import Arrival, End
from improv_core.ipc.priority_queue import UrgentQueue
from improv_core.plain import one_line
from improv_core.protocol.commands import COMMANDS, Conduct, PageRequest
from improv_core.protocol.json_lines import own_output
from improv_core.protocol.limits import STOP_PIPE
from improv_core.protocol.messages import VERSION, FromStage, Ready
from improv_core.protocol.output import Sink
from improv_core.safety.parent_heartbeat import Parent
from improv_core.safety.suspend import asleep
from improv_core.score.joints import JointMotion
from improv_core.score.motion import Twist
from improv_core.stage.loop import EARLY, Opened, run
from improv_core.stage.stdio import Outbox, read_arrivals, read_stops, write_messages

SWITCH_INTERVAL = 0.0005
"""Seconds that a thread of ours may work while the player waits: a long score takes its reader a hundred times that."""

Tell = Callable[[FromStage], None]


def main() -> int:
    """Play what standard input requests until it ends. Returns exit code 1 after a failure, 2 if the sink can't be
    opened."""
    options, say = options_in(sys.argv[1:]), own_output()
    sys.setswitchinterval(SWITCH_INTERVAL)
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    outbox = Outbox()
    pipe = os.environ.pop(STOP_PIPE, None)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: inbox.put(End()))
    writer = threading.Thread(target=write_messages, args=(outbox, say), daemon=True)
    writer.start()
    try:
        opened, ready = open_sink(options, outbox.put, inbox.put, os.environ.get("IMPROV_PAGE_TOKEN"))
    except Exception as error:  # whatever a sink's libraries raise, the one line about it must get out
        outbox.put({"type": "error", "message": one_line(error)})
        code = 2
    else:
        if options.report_sent:
            report_sent(opened.sink, outbox.put)
        parent = Parent()
        if pipe:  # then only messages there show that the parent lives
            threading.Thread(target=read_stops, args=(int(pipe), inbox, parent), daemon=True).start()
        threading.Thread(target=read_arrivals, args=(inbox, None if pipe else parent), daemon=True).start()
        # A garbage collection over all imported modules would make commands late.
        gc.freeze()
        gc.set_threshold(50_000, 20, 100)
        outbox.put(ready)
        code = run(opened, inbox, SystemClock(), parent)
    outbox.put(None)
    writer.join(timeout=1)  # a parent that no longer reads must not keep us alive
    return code


def options_in(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options from the arguments of the command line."""
    parser = argparse.ArgumentParser(prog="improv stage")
    parser.add_argument("--sink", choices=["simulator", "ros"], required=True)
    parser.add_argument("--port", type=int, default=0, help="the page's port; 0 for any free one")
    parser.add_argument("--discovery", help="ROS_AUTOMATIC_DISCOVERY_RANGE, where the environment does not say")
    parser.add_argument("--no-standby", action="store_true", help="no second process to stop robots if this one dies")
    parser.add_argument(
        "--takes-start-poses", action="store_true", help="start poses dragged on the page can be written"
    )
    parser.add_argument("--report-sent", action="store_true", help="tell of every velocity that is sent")
    parser.add_argument("--node", help="the name of the node in ROS 2, if it is not to be unique")
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS's own arguments, to the end")
    return parser.parse_args(arguments)


def open_sink(
    options: argparse.Namespace, put: Tell, hear: Callable[[Arrival], None], token: str | None
) -> tuple[Opened, Ready]:
    """Return the sink that the options name, and the message to send once it is ready.

    `token` opens the simulator's page. The token is no option: all users of the machine can read the arguments of a
    process.
    """
    if options.sink == "ros":
        from improv_core.outputs.ros.output import Ros

        def ask(command: PageRequest) -> None:
            if COMMANDS[command["type"]].at_once:
                hear(cast(Conduct, command))  # now, even if the parent hangs, or gets nothing before we are ready
            put({"type": "request", "command": command})

        arguments = ["--ros-args", *options.ros_args] if options.ros_args else []
        ros = Ros(
            options.discovery,
            not options.no_standby,
            hear,
            ask,
            options.node,
            arguments,
            lambda line: tell_both({"type": "warning", "message": line}),
        )

        def tell_both(message: FromStage) -> None:
            # A speed that was set before the first score is no news: the parent would take it for the end of a score.
            if message["type"] != "transport" or message["generation"]:
                ros.show(message)
                put(message)

        ready: Ready = {"type": "ready", "protocol": VERSION, "sink": ros.description, "real": True}
        return Opened(ros, tell_both, ros.announce, guard=ros.guard, pending_zeros=ros.pending_zeros), ready

    from improv_core.outputs.simulator.simulator import Simulator
    from improv_core.page.server import Viewer

    simulator = Simulator()
    try:
        viewer = Viewer(
            options.port,
            simulator.snapshot,
            lambda command: put({"type": "request", "command": command}),
            takes_start_poses=options.takes_start_poses,
            token=token,
            tell=lambda line: put({"type": "warning", "message": line}),
        )
    except OSError as error:
        if error.errno not in (errno.EADDRINUSE, errno.EACCES):
            raise
        raise OSError(f"the page's port {options.port} is taken: choose another, or 0 for any free one") from error

    def tell(message: FromStage) -> None:
        if message["type"] in ("transport", "stopped", "sensed", "decided", "measured", "armed"):
            viewer.publish(message)
        put(message)

    ready = {"type": "ready", "protocol": VERSION, "sink": simulator.name, "real": False, "page": viewer.address}
    return Opened(simulator, tell, viewer.show, viewer.publish, leave=viewer.close), ready


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


if __name__ == "__main__":
    sys.exit(main())
