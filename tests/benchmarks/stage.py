"""From a save to what robots hear, and how punctual that is: our server and stage beside plain rclpy scripts."""

from __future__ import annotations

import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from tests.benchmarks.drift import simulated_drift
from tests.benchmarks.live import KEYS_A_SECOND, TYPED_LINES, PlayError, anew, beside_typing, crowd, reactions
from tests.benchmarks.robots import RATE, Lateness, Listener
from tests.benchmarks.tables import p99, print_row

LINES = 1_000
CROWD = 1_000
SIMULATED_MINUTES = 10


@dataclass(frozen=True, slots=True)
class Goal:
    """How many milliseconds the median and the 99th percentile may be, where that is fixed."""

    p99: float
    p50: float | None = None

    def __str__(self) -> str:
        middle = f"p50 ≤ {self.p50:g}, " if self.p50 is not None else ""
        return f"{middle}p99 ≤ {self.p99:g}"

    def verdict(self, times: Sequence[float]) -> str:
        met = p99(times) <= self.p99 and (self.p50 is None or median(times) <= self.p50)
        return "met" if met else "not met"


SAVE = Goal(15, 5)
HUSH = Goal(10)
LATE = Goal(1)


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same for a few seconds each."""
    cycles, long_cycles, starts = (12, 6, 4) if quick else (150, 40, 10)
    seconds, plain_seconds, crowd_seconds = (6, 4, 6) if quick else (60, 20, 30)
    _print_machine()
    _print_reactions(cycles, long_cycles, starts)
    _print_punctuality(seconds, plain_seconds)
    _print_drift()
    _print_crowd(crowd_seconds)


def _print_machine() -> None:
    with Listener("drain", []) as listener:
        ros = f"Python {listener.versions['python']} with {listener.versions['rmw']}"
        listener.end()
    cores, load = len(os.sched_getaffinity(0)), os.getloadavg()[0]
    print(f"{cores} cores, load average {load:.2f}, {platform.system()} {platform.release()}, ", end="")
    print(f"server: Python {platform.python_version()}, stage: {ros}")


def _print_reactions(cycles: int, long_cycles: int, starts: int) -> None:
    print(
        "\nFrom a message written to its effect in a listener's rclpy callback, robots already matched, milliseconds\n"
    )
    print_row("what", "times", "p50", "p99", "max", "goal", "")
    print_row("---", *["---:"] * 4, "---", "---")
    small, long = reactions(cycles, 0), reactions(long_cycles, LINES)
    for program, seen in (("one line, one robot", small), (f"{LINES:,} lines, nine robots", long)):
        _print_times(f"save → first Twist: {program}", seen.saves, SAVE)
        _print_times(f"save → first Twist, while another plays: {program}", seen.saves_while_playing, SAVE)
        _print_times(f"`improv.hush` → zero: {program}", seen.hushes, HUSH)
    _print_times("a plain rclpy script started anew → its first Twist", anew(starts), None)
    _print_times("of these but the last: published → in the callback", small.crossing + long.crossing, None)
    print(f"\nSaves that nobody heard anything of: {small.unheard + long.unheard}")
    for problem in small.problems + long.problems:
        print(f"- {problem}")


def _print_punctuality(seconds: int, plain_seconds: int) -> None:
    print(f"\nLateness of commands at {RATE} Hz for {seconds} s, all robots alike, while a client types ", end="")
    print(
        f"{KEYS_A_SECOND} keys a second into {TYPED_LINES:,} lines, milliseconds; below each, ready messages that a ",
        end="",
    )
    print(f"plain rclpy script publishes at absolute times, for {plain_seconds} s, as often typed beside\n")
    parts = [f"{what} {part}" for what in ("published", "received") for part in ("p50", "p99", "max")]
    print_row("robots", "commands", "missing", *parts, "drift, ms a minute", "goal: received", "")
    print_row("---", *["---:"] * 9, "---", "---")
    for count in (1, 10, 100):
        try:
            ours, plain = beside_typing(count, seconds, plain_seconds)
        except PlayError as problem:
            print_row(f"{count}", *[""] * 9, str(LATE), f"not met: {problem}")
            continue
        _print_lateness(f"{count}", ours, LATE)
        _print_lateness(f"{count}, plain script", plain, None)
    print(
        "\nA command ought to be sent at beat 0, as the stage tells the server on the monotonic clock, plus its exact "
        "place in the program. Published and received are Fast DDS's own stamps of both ends, so no listener's Python "
        "is in them; a robot's callback comes later by what the first table says. Missing: by the publisher's numbers."
    )


def _print_drift() -> None:
    commands, off = simulated_drift(SIMULATED_MINUTES)
    print(f"\nDrift after {SIMULATED_MINUTES} simulated minutes, {commands:,} commands in pieces of 1/3 beat: ", end="")
    print(f"at most {off:.1e} s off, goal 0 but for floats: {'met' if off < 1e-9 else 'not met'}")


def _print_crowd(seconds: int) -> None:
    print(f"\n{CROWD:,} robots at {RATE} Hz for {seconds} s, all alike, each with its listener\n")
    try:
        seen = crowd(CROWD, seconds)
    except PlayError as problem:
        print(f"Not kept: {problem}")
        return
    late = seen.lateness
    each_second = sum(at + wait / 1000 < seconds for at, wait in zip(late.due, late.received, strict=True)) / seconds
    met = not late.missing and max(late.received) < 1000 / RATE
    print_row("what", "", "goal", "")
    print_row("---", "---:", "---", "---")
    print_row("commands received a second", f"{each_second:,.0f}", f"{CROWD * RATE:,}", "")
    print_row("missing", f"{late.missing}", "0", "met" if not late.missing else "not met")
    print_row("latest command, ms", f"{max(late.received):.1f}", f"< {1000 / RATE:g}", "met" if met else "not met")
    for name, times in (("published", late.published), ("received", late.received)):
        print_row(f"lateness {name}, ms: p50, p99", f"{median(times):.1f}, {p99(times):.1f}", "", "")
    print_row("the stage's processor seconds a second", f"{seen.stage_cpu:.2f}", "", "")
    print_row("the one listener's", f"{seen.listener_cpu:.2f}", "", "")
    print_row("the stage's memory, MB", f"{seen.memory:.0f}", "", "")
    print_row("first save, none known yet → first Twist, ms", f"{seen.first_save:,.0f}", "", "")
    print_row("later save → first Twist, ms", f"{seen.save:.0f}", "", "")
    print_row("later save → every robot's first Twist, ms", f"{seen.save_to_last:.0f}", "", "")


def _print_times(what: str, times: Sequence[float], goal: Goal | None) -> None:
    figures = (f"{value:.2f}" for value in (median(times), p99(times), max(times)))
    print_row(what, str(len(times)), *figures, str(goal or ""), goal.verdict(times) if goal else "")


def _print_lateness(what: str, late: Lateness, goal: Goal | None) -> None:
    figures = (
        f"{value:.2f}" for times in (late.published, late.received) for value in (median(times), p99(times), max(times))
    )
    verdict = goal.verdict(late.received) if goal else ""
    counts = f"{len(late.received):,}", str(late.missing)
    print_row(what, *counts, *figures, f"{late.drift:+.2f}", str(goal or ""), verdict)
