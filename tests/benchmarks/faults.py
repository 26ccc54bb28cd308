"""Time from a fault to the first zero that a real rclpy subscriber gets, and from a stop that others try to hold up."""

from __future__ import annotations

import asyncio
import http.client
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any
from urllib.parse import urlsplit

import aiohttp

from tests.benchmarks.robots import ENV, PYTHON
from tests.benchmarks.tables import print_head, print_row
from tests.open_page import live_behind
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import LIMIT, Listener, Others
from tests.ros.dance import AFTER, BEFORE, BEFORE_SPEED, URI, Server, Terminal, at_speed, dances, still

TOPIC = "/turtle1/cmd_vel"
HELD_UP = 2.0
"""Seconds of a storm of saves or requests before somebody stops the robots."""
SAVES = 43
"""Saves a second."""

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


def _signal_server(number: signal.Signals) -> Fault:
    def fault(listener: Listener) -> Iterator[float]:
        with Server(ENV) as server:
            dances(server, listener)
            server.client.code = -number
            began = time.monotonic()
            os.kill(server.pid, number)
            yield began
            server.client.process.wait(LIMIT)

    return fault


def _kill_editor(listener: Listener) -> Iterator[float]:
    command = [sys.executable, "-m", "tests.ros.editor", BEFORE]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=ENV, stdin=pipe, stdout=pipe) as editor:
        assert editor.stdout
        editor.stdout.readline()
        listener.wait(at_speed(BEFORE_SPEED))
        began = time.monotonic()
        editor.kill()
        yield began


def _terminal(command: str, end: Callable[[int], None]) -> Fault:
    def fault(listener: Listener) -> Iterator[float]:
        with tempfile.TemporaryDirectory() as folder, Terminal(command, Path(folder, "dance.improv"), ENV) as terminal:
            dances(terminal, listener)
            began = time.monotonic()
            end(terminal.pid)
            yield began

    return fault


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


def _storm(listener: Listener) -> Iterator[float]:
    with Server(ENV) as server:
        dances(server, listener)
        end = time.monotonic() + HELD_UP
        number = 0
        while time.monotonic() < end:
            number += 1
            server.type(AFTER if number % 2 else BEFORE)
            server.client.save(URI)
            time.sleep(1 / SAVES)
        began = time.monotonic()
        _stop(server)
        yield began


def _flood(listener: Listener) -> Iterator[float]:
    with Server(ENV, backend="both") as server:
        dances(server, listener)
        page = server.client.request("workspace/executeCommand", {"command": "improv.page", "arguments": []})
        over = threading.Event()
        flooding = threading.Thread(target=lambda: asyncio.run(_send(str(page), over)))
        flooding.start()
        time.sleep(HELD_UP)
        began = time.monotonic()
        _stop(server)
        yield began
        over.set()
        flooding.join()


async def _send(url: str, over: threading.Event) -> None:
    """Have a page seek as often as it can."""
    live = live_behind(url)
    origin = f"http://{urlsplit(url).netloc}"
    async with aiohttp.ClientSession() as session, session.ws_connect(live, headers={"Origin": origin}) as page:
        beat = 0
        while not over.is_set():
            await page.send_json({"type": "seek", "beat": beat % 7})
            beat += 1


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


def _stop(server: Server) -> None:
    message: dict[str, Any] = {"command": "improv.stop", "arguments": []}
    threading.Thread(target=server.client.request, args=("workspace/executeCommand", message), daemon=True).start()


FAULTS: dict[str, tuple[int, Fault]] = {
    "server SIGKILL": (50, _signal_server(signal.SIGKILL)),
    "server SIGTERM": (50, _signal_server(signal.SIGTERM)),
    "editor SIGKILL": (50, _kill_editor),
    "`play` SIGKILL": (50, _terminal("play", lambda pid: os.kill(pid, signal.SIGKILL))),
    "`play` Ctrl-C": (50, _terminal("play", lambda pid: os.killpg(pid, signal.SIGINT))),
    "`watch` SIGTERM": (50, _terminal("watch", lambda pid: os.kill(pid, signal.SIGTERM))),
    "`watch`'s terminal closed": (50, _terminal("watch", lambda pid: os.killpg(pid, signal.SIGHUP))),
    "stage SIGKILL": (200, _stage(signal.SIGKILL)),
    "stage SIGSTOP": (200, _stage(signal.SIGSTOP)),
    f"stop after {SAVES} saves a second": (100, _storm),
    "stop while a page floods its stage": (100, _flood),
    "page's stop": (50, _page(halted=False)),
    "page's stop, server halted": (50, _page(halted=True)),
}
"""Each fault, and the goal for its worst time in milliseconds."""
