"""Time from a fault to the first zero that a real rclpy subscriber gets, and from a page's stop."""

from __future__ import annotations

import http.client
import os
import signal
import time
from collections.abc import Callable, Generator
from contextlib import closing
from itertools import count, islice
from statistics import median
from urllib.parse import urlsplit

from tests.benchmarks.robots import ENV, PYTHON
from tests.benchmarks.tables import p99, print_head, print_row
from tests.open_page import live_behind
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import LIMIT, Listener, Others
from tests.ros.dance import BEFORE, Server, dances, moving, still

TOPIC = "/turtle1/cmd_vel"
Fault = Callable[[Listener], Generator[float, None, None]]
"""Makes a robot move, then causes its stop, and yields the time of the cause in monotonic seconds, perhaps often."""
SOON = 1.0
"""Seconds until a server that continues counts people as knowing of a stop."""


def run(quick: bool) -> None:
    """Measure and print; `quick` tries each fault twice."""
    print("Milliseconds from a fault to the first zero at a subscriber\n")
    print_head("fault", "times", "median", "p99", "worst", "goal", "")
    for name, (most, goal, fault) in FAULTS.items():
        others = Others(PYTHON, ENV)
        try:
            found = _to_zeros(others, fault, 2 if quick else most)
        finally:
            others.close()
        verdict = "met" if max(found) <= goal else "not met"
        figures = [f"{each:.1f}" for each in (median(found), p99(found), max(found))]
        print_row(name, str(len(found)), *figures, f"≤ {goal}", verdict)


def _to_zeros(others: Others, fault: Fault, most: int) -> list[float]:
    """Return the milliseconds from each of some faults to the first zero. After each run, only the process of the
    listener is left."""
    listener, found = Listener(others, TOPIC), list[float]()
    while len(found) < most:
        with closing(fault(listener)) as causes:
            for began in islice(causes, most - len(found)):
                found.append(1000 * (_first_zero(listener, began) - began))
        wait_until_gone({pid: fd for pid, fd in descendants(os.getpid()).items() if pid != others.pid}, LIMIT)
    return found


def _first_zero(listener: Listener, since: float) -> float:
    return float(listener.wait(lambda message: message["at"] > since and still(message))["at"])


def _kill_server(listener: Listener) -> Generator[float, None, None]:
    with Server(ENV) as server:
        dances(server, listener)
        server.client.code = -signal.SIGKILL
        began = time.monotonic()
        os.kill(server.pid, signal.SIGKILL)
        yield began
        server.client.process.wait(LIMIT)


def _stage(number: signal.Signals) -> Fault:
    def fault(listener: Listener) -> Generator[float, None, None]:
        with Server(ENV) as server:
            dances(server, listener)
            (stage,) = _stages(server.pid)
            began = time.monotonic()
            os.kill(stage, number)
            yield began

    return fault


def _stages(pid: int) -> list[int]:
    """Return the stages below a server: each is the parent of a standby."""
    return [child for child in descendants(pid) if descendants(child)]


def _page(*, halted: bool) -> Fault:
    """Stops of a page, perhaps while the server is halted."""

    def fault(listener: Listener) -> Generator[float, None, None]:
        with Server(ENV, backend="both") as server:
            dances(server, listener)
            live = urlsplit(live_behind(server.client.request("workspace/executeCommand", {"command": "improv.page"})))
            connection = http.client.HTTPConnection(live.netloc, timeout=LIMIT)
            for number in count(1):
                os.kill(server.pid, signal.SIGSTOP if halted else signal.SIGCONT)
                address = f"/stop?{live.query}&page=p&number={number}"
                began = time.monotonic()
                connection.request("POST", address, headers={"Origin": f"http://{live.netloc}"})
                try:
                    yield began
                finally:
                    os.kill(server.pid, signal.SIGCONT)
                assert connection.getresponse().read() == b""
                time.sleep(SOON)
                server.save_until_it_plays(BEFORE)
                listener.wait(moving)

    return fault


FAULTS: dict[str, tuple[int, int, Fault]] = {
    "server SIGKILL": (5, 50, _kill_server),
    "stage SIGKILL": (5, 200, _stage(signal.SIGKILL)),
    "stage SIGSTOP": (5, 200, _stage(signal.SIGSTOP)),
    "page's stop": (100, 50, _page(halted=False)),
    "page's stop, server halted": (100, 50, _page(halted=True)),
}
"""Each fault, how often it is tried, and the goal for its worst time in milliseconds."""
