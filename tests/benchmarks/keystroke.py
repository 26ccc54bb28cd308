"""Time from a changed line to its diagnostics, start, memory, and idle work of the language server."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from itertools import islice
from statistics import median
from time import sleep

from tests.benchmarks.documents import SHARED_LINE, edits, improv
from tests.benchmarks.servers import Seen, Server, memory, processor_time
from tests.benchmarks.tables import machine, p99, print_head, print_row

LONG = 10_000
IDLE = 20
"""Seconds for which an idle server is watched."""
WARM_UP = 20
"""Edits that don't count."""


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer rounds."""
    count, opens, starts = (40, 2, 4) if quick else (200, 5, 10)
    print(f"{machine()}, {platform.system()}, Python {platform.python_version()}\n")
    print(f"didChange written → publishDiagnostics read, milliseconds, {count} edits each\n")
    print_head("lines", "p50", "p99")
    for lines in (100, 1_000, LONG):
        _print_keystrokes(f"{lines:,}", lines, False, count)
    _print_keystrokes(f"{LONG:,}, a third use the name that is edited", LONG, True, count)
    print(f"\nMedians of others; memory is the resident set with {LONG:,} lines open and after 50 edits\n")
    print_head("what", "", "goal", "")
    _print("all lines up to date after that name is edited, ms", _all_settled(count), 200)
    _print(f"first diagnostics of {LONG:,} lines, ms", [_first() for _ in range(opens)], 600)
    _print("process start → `initialize` answered, ms", [_start() for _ in range(starts)])
    now, most = _memory()
    _print("memory, MB", [now], 60)
    _print("memory at most, MB", [most])
    _print(f"processor time while idle for {IDLE} s, % of a core", [_idle()], 0.1)


def _print_keystrokes(about: str, lines: int, shared: bool, count: int) -> None:
    """Edit a document of so many lines; if a third of them use one name, edit its definition."""
    with Server() as server:
        times = [1000 * seen.seconds for seen in islice(_edited(server, lines, shared), WARM_UP, WARM_UP + count)]
    print_row(about, f"{median(times):.2f}", f"{p99(times):.2f}")


def _edited(server: Server, lines: int, shared: bool) -> Iterator[Seen]:
    """Open a document and edit it once for every step. Raises if errors are not found, or others are."""
    text = improv(lines, shared)
    if server.open(text).mistakes:
        raise RuntimeError("the server finds an error in a correct program")
    # The first diagnostics of a long document are those of its beginning; this waits for all.
    server.settle()
    for edit in edits(text, SHARED_LINE if shared else None):
        seen = server.change(edit)
        if not shared and bool(seen.mistakes) != edit.wrong:  # if it is shared, the error may be published later
            raise RuntimeError(f"the server finds {seen.mistakes} errors after {edit}")
        yield seen


def _all_settled(count: int) -> list[float]:
    """Return the milliseconds from an edit of the name that a third of the lines use until all of them are up to
    date."""
    with Server() as server:
        return [1000 * server.settle() for _ in islice(_edited(server, LONG, True), count)]


def _first() -> float:
    with Server() as server:
        return 1000 * server.open(improv(LONG)).seconds


def _start() -> float:
    with Server() as server:
        return 1000 * server.start_seconds


def _memory() -> tuple[float, float]:
    with Server() as server:
        for _ in islice(_edited(server, LONG, False), 50):
            pass
        return memory(server.pid)


def _idle() -> float:
    """Return the percent of a core that the server uses while nobody types and nothing plays."""
    with Server() as server:
        server.open(improv(LONG))
        sleep(1)  # the work after the first diagnostics
        before = processor_time(server.pid)
        sleep(IDLE)
        return (processor_time(server.pid) - before) / IDLE * 100


def _print(what: str, values: list[float], goal: float | None = None) -> None:
    middle = median(values)
    verdict = "" if goal is None else "met" if middle <= goal else "not met"
    print_row(what, f"{middle:.1f}", "" if goal is None else f"≤ {goal:g}", verdict)
