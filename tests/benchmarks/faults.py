"""Time from a fault to the first zero that a real rclpy subscriber gets, and from a page's stop."""

from __future__ import annotations

import http.client
import math
import os
import signal
import time
from collections.abc import Callable, Iterator
from statistics import median
from urllib.parse import urlsplit

from tests.benchmarks.robots import ENV, PYTHON
from tests.benchmarks.tables import print_head, print_row
from tests.open_page import live_behind
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import LIMIT, Listener, Others
from tests.ros.dance import Server, dances, still

TOPIC = "/turtle1/cmd_vel"
Fault = Callable[[Listener], Iterator[float]]
"""Makes a robot move, then causes its stop, and yields the time of the cause in monotonic seconds."""


def run(quick: bool) -> None:
    """Measure and print; `quick` tries each fault twice."""
    rounds = 2 if quick else 5
    print(f"Milliseconds from a fault to the first zero at a subscriber, {rounds} times each\n")
    print_head("fault", "median", "worst", "goal", "")
    for name, (goal, fault) in FAULTS.items():
        others = Others(PYTHON, ENV)
        try:
            listener = Listener(others, TOPIC)
            times = [1000 * _to_zero(others.pid, listener, fault) for _ in range(rounds)]
        finally:
            others.close()
        verdict = "met" if max(times) <= goal else "not met"
        print_row(name, f"{median(times):.0f}", f"{max(times):.0f}", f"≤ {goal}", verdict)


def _to_zero(others: int, listener: Listener, fault: Fault) -> float:
    """Return the seconds from a fault to the first zero; only the process of the listener is left running."""
    zero = math.nan
    for began in fault(listener):
        zero = _first_zero(listener, began) - began
    ours = descendants(os.getpid())
    wait_until_gone({pid: fd for pid, fd in ours.items() if pid != others}, LIMIT)
    return zero


def _first_zero(listener: Listener, since: float) -> float:
    return float(listener.wait(lambda message: message["at"] > since and still(message))["at"])


def _kill_server(listener: Listener) -> Iterator[float]:
    with Server(ENV) as server:
        dances(server, listener)
        server.client.code = -signal.SIGKILL
        began = time.monotonic()
        os.kill(server.pid, signal.SIGKILL)
        yield began
        server.client.process.wait(LIMIT)


def _stage(number: signal.Signals) -> Fault:
    def fault(listener: Listener) -> Iterator[float]:
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
    """A page's stop, perhaps while the server is halted."""

    def fault(listener: Listener) -> Iterator[float]:
        with Server(ENV, backend="both") as server:
            dances(server, listener)
            live = urlsplit(live_behind(server.client.request("workspace/executeCommand", {"command": "improv.page"})))
            connection = http.client.HTTPConnection(live.netloc, timeout=LIMIT)
            connection.connect()
            os.kill(server.pid, signal.SIGSTOP if halted else signal.SIGCONT)
            began = time.monotonic()
            address = f"/stop?{live.query}&page=p&number=1"
            connection.request("POST", address, headers={"Origin": f"http://{live.netloc}"})
            yield began
            os.kill(server.pid, signal.SIGCONT)

    return fault


FAULTS: dict[str, tuple[int, Fault]] = {
    "server SIGKILL": (50, _kill_server),
    "stage SIGKILL": (200, _stage(signal.SIGKILL)),
    "stage SIGSTOP": (200, _stage(signal.SIGSTOP)),
    "page's stop": (50, _page(halted=False)),
    "page's stop, server halted": (50, _page(halted=True)),
}
"""Each fault, and the goal for its worst time in milliseconds."""
