"""The process of the page: its server and, with `--simulate`, the simulator's stage, which plays on the main thread.

Started as `python …/improv_core/page`. The session that starts it sends it JSON lines, as it does any stage, and the
messages for pages in envelopes.
"""

from __future__ import annotations

import argparse
import errno
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import cast

if __name__ == "__main__":
    # As in stage/__main__.py: none of our modules hides another of the same name, and no other version hides ours.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.insert(0, str(here.parent.parent))
    import_module("improv_core")
    sys.path.append(sys.path.pop(0))

from improv_core.ipc.arrivals import End, First, Lost
from improv_core.page.ideal_floor import IdealFloor
from improv_core.page.server import PageServer
from improv_core.protocol.drawn import Snapshot
from improv_core.protocol.limits import STOP_SOCKETS
from improv_core.protocol.messages import VERSION, FromStage, Play, Ready
from improv_core.protocol.page_messages import ForPages, for_pages
from improv_core.safety.heartbeat import Parent
from improv_core.stage.loop import Inbox, OpenedOutput, run
from improv_core.stage.process import HearArrival, Job, SystemClock, Tell, perform, report_sent

TOKEN = "IMPROV_PAGE_TOKEN"
"""The environment variable with the token that opens the page. The token is no option: all users of the machine can
read the arguments of a process."""
SIGNALED = "a signal has ended the process of the page"
"""The problem after a signal. The performance continues, so pages must not say that it is over."""


def main() -> int:
    """Serve the page, and play what standard input requests, until it ends. Returns exit code 1 after a failure, 2 if
    the port is taken."""
    options, show = options_in(sys.argv[1:]), os.environ.get(STOP_SOCKETS)

    def begin(put: Tell, hear: HearArrival) -> Job:
        given = os.environ.get(TOKEN), Path(show) if show else None
        if not options.simulate:
            return open_alone(options, put, hear, *given)
        opened, ready, viewer = open_simulated(options, put, *given)
        if options.report_sent:
            report_sent(opened.sink, put)
        return Job(lambda inbox, parent: run(opened, inbox, SystemClock(), parent), ready, viewer.publish)

    return perform(begin, SIGNALED)


def options_in(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options from the arguments of the command line."""
    parser = argparse.ArgumentParser(prog="improv page")
    parser.add_argument("--simulate", action="store_true", help="play in the simulator")
    parser.add_argument("--port", type=int, default=0, help="the page's port; 0 for any free one")
    parser.add_argument("--usual-port", type=int, default=0, help="the port to take if it is free and --port is 0")
    parser.add_argument(
        "--takes-start-poses", action="store_true", help="start poses dragged on the page can be written"
    )
    parser.add_argument("--report-sent", action="store_true", help="tell of every velocity that is sent")
    return parser.parse_args(arguments)


def open_simulated(
    options: argparse.Namespace, put: Tell, token: str | None, stages: Path | None = None
) -> tuple[OpenedOutput, Ready, PageServer]:
    """Return the simulator's stage, its first message, and the server of the pages that show it, which send their stops
    straight to the `stages` of a show, too. Raises OSError if the port is taken."""
    from improv_core.outputs.simulator.simulator import Simulator

    simulator = Simulator()
    viewer = _serve(options, put, token, stages, simulator.snapshot)
    simulator.label = viewer.label

    def tell(message: FromStage) -> None:
        viewer.report(message)
        put(message)

    return OpenedOutput(simulator, tell, viewer.show), _ready(simulator.name, viewer), viewer


def open_alone(
    options: argparse.Namespace, put: Tell, hear: HearArrival, token: str | None, stages: Path | None = None
) -> Job:
    """Return the work of pages of real robots, which show what the session sends, and send their stops straight to the
    `stages` of a show, too. Raises OSError if the port is taken."""
    floor = IdealFloor()
    viewer = _serve(options, put, token, stages, floor.snapshot, floor)

    def take(message: ForPages) -> None:
        if message["type"] == "sensed":
            floor.sense(message)
        viewer.publish(message)

    def show(inbox: Inbox, _: Parent) -> int:
        while not isinstance(arrival := inbox.get(timeout=None), End):
            message = arrival.message if isinstance(arrival, First) else arrival
            if isinstance(message, Play):
                viewer.show(message.score, message.load["generation"])
            elif isinstance(message, Lost):
                put({"type": "lacks", "generation": message.generation})
            elif isinstance(message, dict) and message["type"] == "page":
                take(cast(ForPages, message["message"]))
            elif isinstance(message, dict) and message["type"] == "ping":
                put({"type": "pong", "number": message["number"]})
        if not arrival.problem:  # otherwise, real robots may dance on, and pages find the next server
            viewer.publish({"type": "stopped"})
        return 1 if arrival.problem else 0

    # Messages get in line behind the scores that they are about.
    return Job(show, _ready("page", viewer), lambda message: hear(for_pages(message)), moves=False)


def _serve(
    options: argparse.Namespace,
    put: Tell,
    token: str | None,
    stages: Path | None,
    snapshot: Callable[[], Snapshot],
    scores: IdealFloor | None = None,
) -> PageServer:
    try:
        return PageServer(
            options.port,
            snapshot,
            lambda command: put({"type": "request", "command": command}),
            usual_port=options.usual_port,
            takes_start_poses=options.takes_start_poses,
            token=token,
            show=stages,
            tell=lambda line: put({"type": "warning", "message": line}),
            scores=scores,
        )
    except OSError as error:
        if not options.port or error.errno not in (errno.EADDRINUSE, errno.EACCES):
            raise
        raise OSError(f"the page's port {options.port} is taken: choose another, or 0 for any free one") from error


def _ready(sink: str, viewer: PageServer) -> Ready:
    return {"type": "ready", "protocol": VERSION, "sink": sink, "real": False, "page": viewer.address}


if __name__ == "__main__":
    sys.exit(main())
