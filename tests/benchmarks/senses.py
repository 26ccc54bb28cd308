"""From a scan published to its edge in the stage, and what a hundred scanners cost commands."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Sequence
from dataclasses import replace
from statistics import median
from typing import Any

from improv_core.score.score import Score
from improv_core.score.senses import Topic
from tests.benchmarks.live import rehearsed
from tests.benchmarks.robots import ENV, HERE, LIMIT, PYTHON, RATE, Lateness, Listener, lateness, play, stage_with
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.stage.test_player import score

CROWD = 100
SELDOM = 10
"""Scans of a scanner after which something changes, if that is not each time."""
REACTION = 4
"""Scans after which something changes for a robot that reacts: its beats are shorter than that."""
P50, P99 = 3.0, 10.0
"""The goal from a scan to its edge, in ms."""
MOST = 1.2
"""How many times later commands may be at the median."""


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same for a few seconds each."""
    seconds, rounds = (4, 1) if quick else (20, 3)
    print(f"{machine()}\n")
    _print_reactions(seconds)
    _print_edges(seconds)
    _print_commands(seconds, rounds)


def _print_reactions(seconds: int) -> None:
    print(f"From a scan published, {RATE} a second, to the changed Twist at a subscriber, milliseconds\n")
    print_head("reactions", "missing", "p50", "p99", "max", "goal", "")
    changes, late = _reactions(seconds)
    met = median(late) <= P50 and p99(late) <= P99
    figures = (f"{value:.2f}" for value in (median(late), p99(late), max(late)))
    verdict = "met" if met else "not met"
    print_row(f"{len(late)}", f"{changes - len(late)}", *figures, f"p50 ≤ {P50:g}, p99 ≤ {P99:g}", verdict)
    print()


def _reactions(seconds: int) -> tuple[int, list[float]]:
    """How many scans changed something, and how long it took until the robot heard that it has to stand, in ms."""
    text = "beat 1200\nr0 $ repeat (until near (repeat forward) until not near (repeat left))\n"
    with Listener("spin", ["/r0/cmd_vel"]) as listener, stage_with(_with_senses(score(text))) as stage:
        published = _told(_python("ros_scanner.py", f"{seconds}", f"{REACTION}", "r0"))
        stage.communicate(timeout=LIMIT)
        heard = listener.end()["/r0/cmd_vel"]
    edges = [at for _, _, at in published[::REACTION]][1:]  # the first says what has been so all along
    stops = [next((each.received for each in heard if each.still and each.received >= at), None) for at in edges]
    late = [(stop - at) * 1000 for stop, at in zip(stops, edges, strict=True) if stop and stop < at + REACTION / RATE]
    return len(edges), late


def _print_edges(seconds: int) -> None:
    print(f"From a scan published, {RATE} a second from each scanner, to its edge in the stage's inbox, milliseconds\n")
    print_head(
        "scanners",
        "edges a second",
        "edges",
        "missing",
        "in the reader p50",
        "p99",
        "in the stage p50",
        "p99",
        "max",
        "goal",
        "",
    )
    for count, every in ((1, 1), (10, 1), (CROWD, SELDOM), (CROWD, 1)):
        changes, read, came = _edges(count, seconds, every)
        met = median(came) <= P50 and p99(came) <= P99
        figures = (f"{value:.2f}" for value in (median(read), p99(read), median(came), p99(came), max(came)))
        counts = (f"{count}", f"{count * RATE // every}", f"{len(came):,}", f"{changes - len(came)}")
        print_row(*counts, *figures, f"p50 ≤ {P50:g}, p99 ≤ {P99:g}", "met" if met else "not met")


def _edges(count: int, seconds: int, every: int) -> tuple[int, list[float], list[float]]:
    """How many scans changed something, and how long each edge took to the reader and to the stage, in ms."""
    robots = [f"r{number}" for number in range(count)]
    with _python("ros_edges.py", *robots) as stage:
        published = _told(_python("ros_scanner.py", f"{seconds}", f"{every}", *robots))
        time.sleep(0.5)
        came = _told(stage)
    scans: dict[str, list[tuple[bool, float]]] = {robot: [] for robot in robots}
    for robot, value, at in published:
        scans[robot].append((value, at))
    read, heard = [], []
    for robot, value, seen, here in came:
        # The first of the latest scans before it that say so.
        at = max((at for close, at in scans[robot][::every] if close == value and at <= seen), default=None)
        if value is not None and at is not None:
            read.append((seen - at) * 1000)
            heard.append((here - at) * 1000)
    return len(published) // every, read, heard


def _print_commands(seconds: int, rounds: int) -> None:
    print(f"\nLateness of commands at {RATE} Hz to {CROWD} robots, {rounds} × {seconds} s in turn, milliseconds\n")
    print_head("what", "commands", "missing", "published p50", "p99", "received p50", "p99", "received p50, times", "")
    ways = {"no scanners": (False, False), "scanners, not read": (True, False), "scanners that are read": (True, True)}
    found: dict[str, list[Lateness]] = {way: [] for way in ways}
    for _ in range(rounds):
        for way, (scanned, read) in ways.items():
            try:
                found[way].append(_commands(seconds, scanned, read))
            except RuntimeError as problem:  # on a machine that is too busy, the stage stops its robots
                print_row(way, f"not kept: {problem}", *[""] * 7)
    if not all(found.values()):
        return
    alone = median(late for each in found["no scanners"] for late in each.received)
    for way, late in found.items():
        published, received = ([value for each in late for value in getattr(each, name)] for name in _ENDS)
        figures = (f"{value:.2f}" for times in (published, received) for value in (median(times), p99(times)))
        ratio = median(received) / alone
        verdict = ("met" if ratio <= MOST else "not met") + f": ≤ {MOST:g}" if ways[way][1] else ""
        missing = sum(each.missing for each in late)
        print_row(way, f"{len(received):,}", f"{missing}", *figures, f"{ratio:.2f}", verdict)


_ENDS = ("published", "received")


def _commands(seconds: int, scanned: bool, read: bool) -> Lateness:
    """How late commands are while scanners publish, and while they are read."""
    robots = [f"r{number}" for number in range(CROWD)]
    topics = [f"/{robot}/cmd_vel" for robot in robots]
    text = f"{' '.join(robots)} $ repeat {seconds // 2} (forward left)\n"
    program = score(text)
    scanners = _python("ros_scanner.py", f"{seconds + 20}", f"{SELDOM}", *robots) if scanned else None
    if scanners:
        assert scanners.stdin
        print(file=scanners.stdin, flush=True)
    try:
        with Listener("drain", topics) as listener:
            zero = play(_with_senses(program) if read else program)
            heard = listener.end()
    finally:
        if scanners:
            scanners.kill()
            scanners.communicate()
    return lateness(heard, zero, rehearsed(text))


def _with_senses(program: Score) -> Score:
    def near(robot: str) -> Topic:
        return Topic(f"/{robot}/scan", "sensor_msgs/LaserScan", below=0.5, start=-0.52, end=0.52)

    return replace(
        program, parts={name: replace(part, senses={"near": near(name)}) for name, part in program.parts.items()}
    )


def _python(script: str, *arguments: str) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    return subprocess.Popen([PYTHON, str(HERE / script), *arguments], env=ENV, stdin=pipe, stdout=pipe, text=True)


def _told(process: subprocess.Popen[str]) -> Sequence[Any]:
    """What a process says, once its input has ended."""
    told, _ = process.communicate(timeout=LIMIT)
    found: Sequence[Any] = json.loads(told)
    return found
