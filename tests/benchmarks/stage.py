"""Time from a save to the robots' messages, and their punctuality: our server and stage beside a plain rclpy script."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from tests.benchmarks.background import KEYS_A_SECOND, TYPED_LINES, busy_editor
from tests.benchmarks.live import LOOP_IN_WORDS, OURS_IN_WORDS, PlayError, in_turns, reactions
from tests.benchmarks.robots import RATE, Lateness, Listener
from tests.benchmarks.tables import p99, print_head, print_row

LINES = 1_000


@dataclass(frozen=True, slots=True)
class Goal:
    """Limits in milliseconds of the median and the 99th percentile, where they are fixed."""

    p99: float
    p50: float | None = None

    def __str__(self) -> str:
        middle = f"p50 ≤ {self.p50:g}, " if self.p50 is not None else ""
        return f"{middle}p99 ≤ {self.p99:g}"

    def verdict(self, times: Sequence[float]) -> str:
        met = p99(times) <= self.p99 and (self.p50 is None or median(times) <= self.p50)
        return "met" if met else "not met"


SAVE = Goal(8, 3)
LONG_SAVE = Goal(15, 5)
STOP = Goal(5)
LATE = "p50 ≤ 1.1 ×, p99 ≤ 1.2 × the absolute loop"


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same for a few seconds each."""
    cycles, long_cycles = (12, 6) if quick else (150, 40)
    rounds, seconds = (2, 4) if quick else (5, 10)
    _print_machine()
    with busy_editor():
        _print_reactions(cycles, long_cycles)
        _print_punctuality(rounds, seconds)


def _print_machine() -> None:
    with Listener("drain", []) as listener:
        ros = f"Python {listener.versions['python']} with {listener.versions['rmw']}"
        listener.end()
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    print(f"{cores} cores, load average {load:.2f}, {platform.system()} {platform.release()}, ", end="")
    print(f"server: Python {platform.python_version()}, stage: {ros}")


def _print_reactions(cycles: int, long_cycles: int) -> None:
    print(
        f"\nBeside a dance in the simulator, its page in Chromium, and {KEYS_A_SECOND} keys a second typed into "
        f"{TYPED_LINES:,} lines.\n\nFrom a message written to its effect in a listener's rclpy callback, robots "
        "already matched, milliseconds\n"
    )
    print_head("what", "times", "p50", "p99", "max", "goal", "")
    small, long = reactions(cycles, 0), reactions(long_cycles, LINES)
    programs = (("one line, one robot", small, SAVE), (f"{LINES:,} lines, nine robots", long, LONG_SAVE))
    for program, seen, goal in programs:
        _print_times(f"save → first Twist: {program}", seen.saves, goal)
        _print_times(f"save → first Twist, while another plays: {program}", seen.saves_while_playing, goal)
        _print_times(f"`improv.stop` → zero: {program}", seen.stops, STOP)
    _print_times("of these but the last: published → in the callback", small.crossing + long.crossing, None)
    print(f"\nSaves that nobody heard anything of: {small.unheard + long.unheard}")
    for problem in small.problems + long.problems:
        print(f"- {problem}")


def _print_punctuality(rounds: int, seconds: int) -> None:
    print(
        f"\nLateness of commands at {RATE} Hz, all robots alike, another velocity each second. In {rounds} rounds, ",
        end="",
    )
    print(f"Improv and a plain rclpy script take turns of {seconds} s. Milliseconds\n")
    parts = [f"{what} {part}" for what in ("published", "received", "changes received") for part in ("p50", "p99")]
    print_head("robots", "who", "commands", "missing", *parts, "longest gap", "changes: × the loop", LATE)
    for count in (1, 10, 100):
        try:
            found = in_turns(count, rounds, seconds)
        except PlayError as problem:
            print_row(f"{count}", OURS_IN_WORDS, *[""] * 10, f"not met: {problem}")
            continue
        for who, late in found.items():
            _print_lateness(count, who, late, found[LOOP_IN_WORDS])
    print(
        "\nA command ought to be sent at beat 0, as the stage tells the server on the monotonic clock, plus its place "
        "in a rehearsal. Published and received are Fast DDS's own stamps of both ends, so no listener's Python is in "
        "them; a robot's callback comes later by what the first table says. Missing repeats were "
        "skipped since they were overdue by a period; all of a topic's turn is then left out except changes."
    )


def _print_times(what: str, times: Sequence[float], goal: Goal | None) -> None:
    figures = (f"{value:.2f}" for value in (median(times), p99(times), max(times)))
    print_row(what, str(len(times)), *figures, str(goal or ""), goal.verdict(times) if goal else "")


def _print_lateness(count: int, who: str, late: Lateness, loop: Lateness) -> None:
    if not late.changes or not loop.changes:
        print_row(f"{count}", who, "0", str(late.missing), *[""] * 8, "")
        return
    figures = (
        f"{value:.2f}" if times else "?"
        for times in (late.published, late.received, late.changes)
        for value in ((median(times), p99(times)) if times else (0, 0))
    )
    middle, worst = median(late.changes) / median(loop.changes), p99(late.changes) / p99(loop.changes)
    verdict = ("met" if middle <= 1.1 and worst <= 1.2 else "not met") if who == OURS_IN_WORDS else ""
    counts = f"{len(late.received) + late.missing:,}", str(late.missing)
    print_row(f"{count}", who, *counts, *figures, f"{late.longest:.0f}", f"{middle:.2f}, {worst:.2f}", verdict)
