"""Time from the first save of a session to the first Twist that robots hear, and whether they hear all of it."""

from __future__ import annotations

import time
from itertools import pairwise
from statistics import median

from tests.benchmarks.robots import ENV, PYTHON, Listener
from tests.benchmarks.servers import Server
from tests.benchmarks.tables import print_head, print_row

GOAL = 1.5
"""Seconds to the first Twist if somebody saves as soon as the program is open."""
WARM = 10.0
"""Seconds after which everything has started that an opened program starts."""
ROBOTS = [f"r{number}" for number in range(12)]
PROGRAM = f"beat 60\n{' '.join(ROBOTS)} $ forward left\n"
HEARD = 2.5
"""Seconds for which the program plays."""


def measure(backend: str, waits: float) -> tuple[float, list[float]]:
    """Save the first program of a session, after some seconds. Return the seconds until a robot moved, and for each
    robot the milliseconds by which its first movement was cut short."""
    topics = [f"/{robot}/cmd_vel" for robot in ROBOTS]
    options = {"backend": backend, "page": {"open": False}, "ros": {"python": PYTHON}}
    with Listener("spin", topics) as listener, Server(options, ENV) as server:
        server.open(PROGRAM)
        time.sleep(waits)
        saved = server.save()
        server.client.wait_for_line("▶")
        time.sleep(5 + HEARD)
        heard = listener.end()
    moving = {topic: [each for each in heard[topic] if not each.still] for topic in topics}
    changes = {
        topic: [two for one, two in pairwise([None, *each]) if two and (not one or one.velocity != two.velocity)]
        for topic, each in moving.items()
    }
    cut = [1000 * (1 - each[1].received + each[0].received) for each in changes.values()]
    return min(each[0].heard for each in changes.values()) - saved, cut


def run(quick: bool) -> None:
    """Print the time to the first Twist, at once after the start and later, and the first movements cut short."""
    rounds = 3 if quick else 10
    print(
        f"{len(ROBOTS)} robots, which listen already; the goal is {GOAL:g} s for a save as soon as a program is open\n"
    )
    print_head("backend", "saved", "times", "median", "worst", "first movements", "cut by 30 ms or more", "most")
    for backend in ("ros", "both"):
        for waits in (0.0, WARM):
            found = [measure(backend, waits) for _ in range(rounds)]
            times, cut = [seconds for seconds, _ in found], [each for _, robots in found for each in robots]
            figures = (
                f"{median(times):.2f} s",
                f"{max(times):.2f} s",
                str(len(cut)),
                str(sum(each >= 30 for each in cut)),
            )
            print_row(
                backend, f"after {waits:g} s" if waits else "at once", str(rounds), *figures, f"{max(cut):.0f} ms"
            )
