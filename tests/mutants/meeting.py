"""Runs the tests against a fault: in a copy of the tree, those that run its lines, the fastest first, until one
fails."""

from __future__ import annotations

import ast
import json
import os
import queue
import signal
import subprocess
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from tests.mutants.copies import copy_tree
from tests.mutants.coverage_map import Map
from tests.mutants.faults import Fault
from tests.mutants.plugin import ORDER, TIMES

FIRST = 80
"""Tests that run before all others that run the lines: they notice most faults at once."""
TEST_LIMIT, RUN_LIMIT = 90, 1800
"""Seconds for one test, and for one run of tests; a test that takes longer has noticed the fault, a run has not."""


@dataclass(frozen=True)
class Verdict:
    """The test that noticed a fault, and the seconds until then."""

    fault: Fault
    killer: str | None
    seconds: float
    tried: int

    def __str__(self) -> str:
        by = f"noticed by {self.killer}" if self.killer else f"SURVIVED {self.tried} tests"
        return f"{self.fault.file}: {self.fault.breaks}\n    {by}, {self.seconds:.0f} s"


class Laboratory:
    """Copies of the tree, one for each fault that is tested at the same time."""

    def __init__(self, commit: str | None, jobs: int, covered: Map) -> None:
        self._temporary = tempfile.TemporaryDirectory(prefix="improv-mutants-", ignore_cleanup_errors=True)
        self._map = covered
        self._copies: queue.SimpleQueue[tuple[Path, Path]] = queue.SimpleQueue()
        for number in range(jobs):
            copy = Path(self._temporary.name) / str(number) / "copy"
            copy.parent.mkdir()
            self._copies.put((copy, copy_tree(commit, copy)))
            self._any = copy

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._temporary.cleanup()

    def fits(self, fault: Fault) -> bool:
        """Return whether the source has the original of the fault, once."""
        return (self._any / "improv_core" / fault.file).read_text().count(fault.original) == 1

    def meet(self, fault: Fault, whole: bool) -> Verdict:
        """Run the tests of a fault's lines, and if it survives and `whole`, all others."""
        began = time.monotonic()
        touching = self._map.tests(fault)
        others = [test for test in self._map.all if test not in set(touching)] if whole else []
        copy, python = self._copies.get()
        path = copy / "improv_core" / fault.file
        source = path.read_text()
        try:
            mutated = source.replace(fault.original, fault.mutated)
            ast.parse(mutated)
            _write(path, mutated)
            killer = None
            for tests in (touching[:FIRST], touching[FIRST:], others):
                killer = killer or _killer(copy, python, tests)
        finally:
            _write(path, source)
            self._copies.put((copy, python))
        return Verdict(fault, killer, time.monotonic() - began, len(touching) + len(others))


def _write(path: Path, source: str) -> None:
    path.write_text(source)
    for compiled in path.parent.glob(f"__pycache__/{path.stem}.*"):  # it may have the same time and size
        compiled.unlink()


def _killer(copy: Path, python: Path, tests: list[str]) -> str | None:
    """Return the first of these tests that fails, twice: on a busy machine, a test may fail without a fault."""
    while tests:
        failed = _run(copy, python, tests)
        if failed is None or _run(copy, python, [failed]) == failed:
            return failed
        tests = tests[tests.index(failed) + 1 :]
    return None


def _run(copy: Path, python: Path, tests: list[str]) -> str | None:
    """Run tests in this order. Return the first that fails."""
    order, times = copy.parent / "order", copy.parent / "times"
    order.write_text("\n".join(tests))
    times.unlink(missing_ok=True)
    files = dict.fromkeys(test.partition("::")[0] for test in tests)
    options = ["-q", "-x", "-n0", "-p", "tests.mutants.plugin", "-p", "no:cacheprovider", "--timeout", str(TEST_LIMIT)]
    running = subprocess.Popen(
        [python, "-m", "pytest", *options, *files],
        cwd=copy,
        env={**os.environ, ORDER: str(order), TIMES: str(times)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        running.wait(RUN_LIMIT)
    except subprocess.TimeoutExpired:
        with suppress(ProcessLookupError):
            os.killpg(running.pid, signal.SIGKILL)
        running.wait()
    if not times.exists():  # pytest can't even collect them, or it was stopped
        return tests[0] if running.returncode == 2 else None
    ended: dict[str, tuple[str, float]] = json.loads(times.read_text())
    if not ended and running.returncode == 2:
        return tests[0]
    return next((test for test, (outcome, _) in ended.items() if outcome == "failed"), None)
