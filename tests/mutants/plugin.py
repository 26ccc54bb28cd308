"""Pytest's side of a run in a copy: the coverage and the time of each test, or the tests to run in order.

It works beside any version of the tests, so it relies on nothing else here.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import weakref
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

ORDER = "IMPROV_MUTANTS_ORDER"
"""Name of the variable with the file that lists the tests to run, one a line, in this order."""
TIMES = "IMPROV_MUTANTS_TIMES"
"""Name of the variable with the file for the outcome of each test, and its seconds."""
CONTEXT = "IMPROV_MUTANTS_CONTEXT"
"""The test that started a process, for which `coverage` records the lines that the process runs."""

START = "COVERAGE_PROCESS_START"
"""Name of the variable with the settings with which `coverage` measures a process from its start."""
CHILDREN = "IMPROV_MUTANTS_CHILDREN"
"""Name of the variable with the settings for processes of tests: `coverage` looks for greenlets in the tests alone."""

_runtime = tempfile.TemporaryDirectory(prefix="improv-mutants-")
_ended: dict[str, tuple[str, float]] = {}


def pytest_configure(config: pytest.Config) -> None:
    # Older versions of the tests give their workers no folder of their own for `improv stop`.
    os.environ["XDG_RUNTIME_DIR"] = _runtime.name
    if measuring := Coverage.current():
        _look_for_greenlets_in_the_main_thread(measuring)
    if hasattr(config, "workerinput") and CHILDREN in os.environ:
        os.environ[START] = os.environ[CHILDREN]
        _tell_processes()


def _look_for_greenlets_in_the_main_thread(measuring: Coverage) -> None:
    """Have `coverage` look for greenlets only in the main thread, where Playwright's are.

    If it looks for them in other threads, each of these gives the main thread a task when it ends. While that thread
    waits, traced threads repeat it without end (Python 3.11).
    """
    same: Any = weakref.ref(pytest_configure)  # each thread has its own tracer, so one key is enough
    if collector := measuring._collector:
        collector.concur_id_func = same


def _tell_processes() -> None:
    """Pass the settings of the measurement to every process of a test, even if the test gives it an environment without
    them."""
    start: Any = subprocess.Popen.__init__

    def measured(self: Any, *positional: Any, env: Any = None, **named: Any) -> None:
        ours = {name: os.environ[name] for name in (CONTEXT, START) if name in os.environ}
        start(self, *positional, env={**(os.environ if env is None else env), **ours}, **named)

    subprocess.Popen.__init__ = measured  # type: ignore[method-assign]


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if ORDER not in os.environ:
        return
    place = {test: number for number, test in enumerate(Path(os.environ[ORDER]).read_text().splitlines())}
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in place])
    items[:] = sorted((item for item in items if item.nodeid in place), key=lambda item: place[item.nodeid])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    if measuring := Coverage.current():
        os.environ[CONTEXT] = item.nodeid
        measuring.switch_context(item.nodeid)
    return (yield)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    outcome, seconds = _ended.get(report.nodeid, ("passed", 0.0))
    if outcome == "passed":
        outcome = report.outcome
    _ended[report.nodeid] = outcome, seconds + report.duration


def pytest_sessionfinish(session: pytest.Session) -> None:
    if TIMES in os.environ and not hasattr(session.config, "workerinput"):
        Path(os.environ[TIMES]).write_text(json.dumps(_ended))
