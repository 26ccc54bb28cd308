"""Time from a changed line to its diagnostics, start, and memory: our server, ruff and a bare pygls, side by side."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from itertools import islice
from statistics import median
from time import sleep

from tests.benchmarks.documents import SHARED_LINE, Uses, edits
from tests.benchmarks.servers import ALL, BARE, OURS, RUFF, Kind, Seen, Server, memory, processor_time
from tests.benchmarks.tables import p99, print_head, print_row

Samples = dict[Kind, list[float]]
"""Measurements of each server: milliseconds, or MB."""

LONG = 10_000
IDLE = 20
"""Seconds for which an idle server is watched."""
AT_ONCE = 20
"""Edits that one server gets before the next server's turn: a disturbance of the machine affects all three."""


@dataclass(frozen=True, slots=True)
class Goal:
    """Limit of our median: so many times that of another server, or so many units."""

    limit: float
    against: Kind | None = None
    unit: str = ""

    def __str__(self) -> str:
        return f"≤ {self.limit:g} × {self.against.name}" if self.against else f"≤ {self.limit:g} {self.unit}"

    def verdict(self, samples: Samples) -> str:
        ours = median(samples[OURS])
        return "met" if ours <= self.limit * (median(samples[self.against]) if self.against else 1) else "not met"


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer rounds."""
    rounds, opens, starts = (2, 2, 4) if quick else (10, 5, 10)
    cores = len(os.sched_getaffinity(0))
    versions = f"pygls {version('pygls')}, ruff {version('ruff')}"
    print(f"{cores} cores, {platform.system()}, Python {platform.python_version()}, {versions}\n")
    print(f"didChange written → publishDiagnostics read, milliseconds, {rounds * AT_ONCE} edits each\n")
    print_row("lines", *(f"{kind.name} {part}" for kind in ALL for part in ("p50", "p99")), "ours / ruff", "goal", "")
    print_row(*["---:"] * 8, "---", "---")
    for lines, goal in ((100, 2), (1_000, 1), (LONG, 0.5)):
        _print_keystrokes(f"{lines:,}", _keystrokes(lines, "", rounds), Goal(goal, RUFF))
    _print_keystrokes(f"{LONG:,}, a third use phrases", _keystrokes(LONG, "phrase", rounds), Goal(0.5, RUFF))
    shared = f"{LONG:,}, a third use the name that is edited"
    _print_keystrokes(shared, _keystrokes(LONG, "name", rounds), Goal(50, unit="ms"))
    print(f"\nOther medians; memory is the resident set with {LONG:,} lines open and after 50 edits\n")
    print_head("what", *(kind.name for kind in ALL), "goal", "")
    _print_other(
        "all lines up to date after that name is edited, ms", {OURS: _all_settled(rounds)}, Goal(200, unit="ms")
    )
    first, with_phrases = _repeated(opens, partial(_first, "")), _repeated(opens, partial(_first, "phrase"))
    _print_other(f"first diagnostics of {LONG:,} lines, ms", first, Goal(600, unit="ms"))
    _print_other("with phrases, ms", with_phrases, Goal(1000, unit="ms"))
    _print_other("process start → `initialize` answered, ms", _repeated(starts, _start), Goal(1.1, BARE))
    documents: Sequence[tuple[str, Uses, float]] = (("memory", "", 60), ("memory with phrases", "phrase", 80))
    for what, uses, goal in documents:
        memories = {kind: _memory(kind, uses) for kind in ALL}
        now, most = ({kind: [each[place]] for kind, each in memories.items()} for place in (0, 1))
        _print_other(f"{what}, MB", now, Goal(goal, unit="MB"))
        _print_other(f"{what} at most, MB", most, None)
    _print_other(f"processor time while idle for {IDLE} s, % of a core", _repeated(1, _idle), Goal(0.1, unit="%"))


def _keystrokes(lines: int, uses: Uses, rounds: int) -> Samples:
    """Edit a document of so many lines; if a third of them use one name, edit its definition."""
    samples: Samples = {kind: [] for kind in ALL}
    with ExitStack() as stack:
        change = {kind: _opened(stack.enter_context(Server(kind)), kind, lines, uses) for kind in ALL}
        for turn in range(rounds + 1):
            for kind in ALL:
                times = [seen.seconds * 1000 for seen in islice(change[kind], AT_ONCE)]
                if turn:  # the first one warms up
                    samples[kind] += times
    return samples


def _opened(server: Server, kind: Kind, lines: int, uses: Uses = "") -> Iterator[Seen]:
    """Open a document and edit it once for every step. Raises if errors are not found, or others are."""
    text = kind.language.write(lines, uses)
    if server.open(text).mistakes:
        raise RuntimeError(f"{kind.name} finds a mistake where none is")
    if kind is OURS:  # the first diagnostics of a long document are those of its beginning; this waits for all
        place = {"textDocument": {"uri": server.uri}, "position": {"line": SHARED_LINE, "character": 0}}
        server.request("textDocument/rename", {**place, "newName": "other"})
    for edit in edits(kind.language, text, SHARED_LINE if uses == "name" else None):
        seen = server.change(edit)
        if kind.finds_mistakes and bool(seen.mistakes) != edit.wrong:
            raise RuntimeError(f"{kind.name} gives {seen.mistakes} mistakes after {edit}")
        yield seen


def _repeated(times: int, measure: Callable[[Kind], float]) -> Samples:
    samples: Samples = {kind: [] for kind in ALL}
    for _ in range(times):
        for kind in ALL:
            samples[kind].append(measure(kind))
    return samples


def _all_settled(rounds: int) -> list[float]:
    """Return the milliseconds from an edit of the name that a third of the lines use until all of them are up to
    date."""
    with Server(OURS) as server:
        change = _opened(server, OURS, LONG, "name")
        return [server.settle() * 1000 for _ in islice(change, rounds * AT_ONCE)]


def _first(uses: Uses, kind: Kind) -> float:
    with Server(kind) as server:
        return server.open(kind.language.write(LONG, uses)).seconds * 1000


def _idle(kind: Kind) -> float:
    """Return the percent of a core that a server uses while nobody types and nothing plays."""
    with Server(kind) as server:
        server.open(kind.language.write(LONG, ""))
        sleep(1)  # the work after the first diagnostics
        before = processor_time(server.pid)
        sleep(IDLE)
        return (processor_time(server.pid) - before) / IDLE * 100


def _start(kind: Kind) -> float:
    with Server(kind) as server:
        return server.start_seconds * 1000


def _memory(kind: Kind, uses: Uses) -> tuple[float, float]:
    with Server(kind) as server:
        for _ in islice(_opened(server, kind, LONG, uses), 50):
            pass
        return memory(server.pid)


def _print_keystrokes(what: str, samples: Samples, goal: Goal) -> None:
    times = (f"{value:.2f}" for kind in ALL for value in (median(samples[kind]), p99(samples[kind])))
    ratio = median(samples[OURS]) / median(samples[RUFF])
    print_row(what, *times, f"{ratio:.2f}", str(goal), goal.verdict(samples))


def _print_other(what: str, samples: Samples, goal: Goal | None) -> None:
    values = (f"{median(samples[kind]):.1f}" if kind in samples else "" for kind in ALL)
    print_row(what, *values, str(goal or ""), goal.verdict(samples) if goal else "")
