"""Time from a changed line to its diagnostics, start, memory, and idle work of the language server."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from itertools import islice
from statistics import median
from time import sleep

from tests.benchmarks.documents import PYTHON, SHARED_LINE, edits, improv, python
from tests.benchmarks.servers import RUFF, RUFF_OPTIONS, Seen, Server, memory, processor_time
from tests.benchmarks.tables import machine, p99, print_head, print_row

LONG = 10_000
IDLE = 20
"""Seconds for which an idle server is watched."""
AT_ONCE = 20
"""Edits that one server gets before the other one's turn: a disturbance of the machine affects both."""
MODULE = "file:///benchmark/document.py"


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer rounds."""
    count, opens, starts = (40, 2, 4) if quick else (200, 5, 10)
    print(f"{machine()}, {platform.system()}, Python {platform.python_version()}\n")
    print(
        f"didChange written → publishDiagnostics read, milliseconds, {count} edits each, in turns with `ruff server`\n"
    )
    print_head("lines", "p50", "p99", "ruff's p50", "p99", "ours / ruff")
    for lines in (100, 1_000, LONG):
        _print_keystrokes(f"{lines:,}", lines, False, count)
        _print_keystrokes(f"{lines:,}, a third use the name that is edited", lines, True, count)
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
    """Edit a document of this many lines; if a third of them use one name, edit its definition."""
    with Server() as ours, Server(RUFF_OPTIONS, command=RUFF, uri=MODULE, language="python") as ruff:
        times: tuple[list[float], list[float]] = [], []
        both = _edited(ours, lines, shared), _edited_python(ruff, lines)
        for turn in range(-1, count // AT_ONCE):
            for edited, found in zip(both, times, strict=True):
                seconds = [1000 * seen.seconds for seen in islice(edited, AT_ONCE)]
                found += seconds if turn >= 0 else []  # the first turn warms up
    figures = [f"{value:.2f}" for found in times for value in (median(found), p99(found))]
    print_row(about, *figures, f"{median(times[0]) / median(times[1]):.2f}")


def _edited(server: Server, lines: int, shared: bool) -> Iterator[Seen]:
    """Open a document and edit it once for every step. Raises if errors are not found, or others are."""
    text = improv(lines, shared)
    server.open(text)
    # The first diagnostics of a long document are those of its beginning; this waits for all.
    server.settle()
    if server.mistakes():
        raise RuntimeError("the server finds an error in a correct program")
    for edit in edits(text, SHARED_LINE if shared else None):
        seen = server.change(edit)
        if bool(seen.mistakes) != edit.wrong:  # they are those of the beginning, too
            server.settle()
            if bool(server.mistakes()) != edit.wrong:
                raise RuntimeError(f"the server finds {server.mistakes()} errors after {edit}")
        yield seen


def _edited_python(server: Server, lines: int) -> Iterator[Seen]:
    """Do the same with a server for Python and a module as long."""
    text = python(lines)
    server.open(text)
    for edit in edits(text, added=PYTHON):
        yield server.change(edit)


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
