"""Time limits of tests, their order, and the summary at the end of a run.

A test that takes more than `EXPLAINED` seconds gives the reason: `@pytest.mark.slow("starts VS Code")`. In CI, a test
without that mark fails if it takes more than `LONGEST` seconds, without those for which it waited for a processor. On a
machine with other work, it may take longer: then the processes that it starts wait as well.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Generator, Iterable
from pathlib import Path

import pytest

EXPLAINED = 3.0
LONGEST = 30.0
IN_CI = "IMPROV_REQUIRE_ALL" in os.environ

_waited = 0.0  # for a processor, until the last report


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", f"slow(reason): takes more than {EXPLAINED:g} s, for this reason")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        for mark in item.iter_markers("slow"):
            if not mark.args:
                raise pytest.UsageError(f"{item.nodeid}: say why it is slow: @pytest.mark.slow(reason)")
    if hasattr(config, "workerinput"):  # with several workers, the files that take longest begin first
        slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
        all_tests = Counter(item.path for item in items)
        items.sort(key=lambda item: (-slow[item.path], -all_tests[item.path], item.path))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    global _waited
    report = yield
    if not IN_CI:
        return report
    before, _waited = _waited, waited_for_processor()
    took = call.duration - (_waited - before)
    if report.passed and took > longest() and not item.get_closest_marker("slow"):
        report.outcome = "failed"
        report.longrepr = (
            f"This took {took:.1f} s. In CI, a test may take {longest():.0f} s unless it says why it needs more: "
            "@pytest.mark.slow(reason)"
        )
    return report


def longest() -> float:
    """Return the seconds that a test may take now. These tests alone keep about two processes ready to run for each
    worker."""
    own = 2 * int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    return LONGEST * max(1.0, os.getloadavg()[0] / own)


def waited_for_processor() -> float:
    """Return the seconds for which this thread was ready to run, but other work had all processors: no fault of a test.
    0 if the system doesn't report it."""
    try:
        return int(Path("/proc/thread-self/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    except OSError:
        return 0.0


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for line in unexplained(terminalreporter.stats.get("passed", [])) if IN_CI else ():
        terminalreporter.write_line(line)


def unexplained(reports: Iterable[pytest.TestReport]) -> list[str]:
    """Return a line for each test that took too long without a reason."""
    return [
        f"took {report.duration:.1f} s and does not say why: {report.nodeid}"
        for report in reports
        if report.duration > EXPLAINED and "slow" not in report.keywords
    ]
