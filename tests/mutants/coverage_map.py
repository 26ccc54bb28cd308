"""Runs the whole suite under `coverage`, child processes and ROS's Python included, and reports the covered lines."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from coverage import CoverageData

from tests.mutants.copies import RESULTS, copy_tree, measure_ros
from tests.mutants.faults import Fault
from tests.mutants.plugin import CHILDREN, START, TIMES

SETTINGS = """\
[run]
branch = true
parallel = true
sigterm = true
data_file = {folder}/map
concurrency = {concurrency}
context = ${{IMPROV_MUTANTS_CONTEXT-}}
source =
    {copy}/improv_core
    {copy}/improv_ls
disable_warnings = no-data-collected, module-not-imported, module-not-measured
"""


def measure(commit: str | None, jobs: int, wanted: list[str]) -> None:
    """Run the tests in a copy; keep the lines that each test covers, its time, and the coverage of each file."""
    with tempfile.TemporaryDirectory(prefix="improv-coverage-") as temporary:
        copy, folder = Path(temporary) / "copy", Path(temporary) / "data"
        folder.mkdir()
        python = copy_tree(commit, copy)
        settings = {name: folder / f"{name}.ini" for name in ("tests", "children")}
        for name, concurrency in (("tests", "thread, greenlet"), ("children", "thread")):
            settings[name].write_text(SETTINGS.format(folder=folder, concurrency=concurrency, copy=copy))
        measure_ros(copy)
        kept = RESULTS / (commit or "tree")
        kept.mkdir(parents=True, exist_ok=True)
        files = {START: settings["tests"], CHILDREN: settings["children"], TIMES: kept / "times.json"}
        env = {**os.environ, **{name: str(file) for name, file in files.items()}}
        pytest: list[str | Path] = [python, "-m", "pytest", "-p", "tests.mutants.plugin", "-q", "--timeout", "300"]
        subprocess.run([*pytest, "-n", str(jobs), "--dist", "loadfile", *wanted], cwd=copy, env=env)
        (kept / "map").unlink(missing_ok=True)
        data, report = f"--data-file={kept / 'map'}", kept / "coverage.json"
        subprocess.run([python, "-m", "coverage", "combine", "-q", data, folder], cwd=copy, check=True)
        subprocess.run([python, "-m", "coverage", "json", "-q", data, "-o", report], cwd=copy, check=True)
        shutil.copytree(copy / "improv_core", kept / "improv_core", dirs_exist_ok=True, ignore=_COMPILED)


class Map:
    """Finds the tests, of those that passed, that run the lines that a fault changes."""

    def __init__(self, commit: str | None) -> None:
        self._kept = RESULTS / (commit or "tree")
        self._data = CoverageData(str(self._kept / "map"))
        self._data.read()
        ended: dict[str, tuple[str, float]] = json.loads((self._kept / "times.json").read_text())
        self._seconds = {test: seconds for test, (outcome, seconds) in ended.items() if outcome == "passed"}
        self.all = self._fastest(self._seconds)
        """All tests that passed, the fastest first."""

    def tests(self, fault: Fault) -> list[str]:
        """Return the tests that ran the lines, as they were then, the fastest first."""
        source = (self._kept / "improv_core" / fault.file).read_text()
        before, original, _ = source.partition(fault.original)
        first = before.count("\n") + 1
        lines = range(first, first + len(original.splitlines()))
        names = [name for name in self._data.measured_files() if name.endswith(f"/copy/improv_core/{fault.file}")]
        contexts = self._data.contexts_by_lineno(names[0]) if names else {}
        return self._fastest({test for line in lines for test in contexts.get(line, [])} & self._seconds.keys())

    def _fastest(self, tests: Iterable[str]) -> list[str]:
        return sorted(tests, key=self._seconds.__getitem__)


_COMPILED = shutil.ignore_patterns("__pycache__")


def table(*commits: str | None) -> str:
    """Return the shares of statements and branches that are covered, by package, side by side."""
    names = [each or "tree" for each in commits]
    totals = [_by_package(_files(each)) for each in commits]
    return "\n".join(
        [
            f"{'':16}" + "".join(f"{each:>22}" for each in names),
            f"{'':16}" + len(names) * f"{'statements':>12}{'branches':>10}",
            *(
                f"{package:16}" + "".join(_shares(each.get(package, {})) for each in totals)
                for package in [*sorted(set().union(*totals) - {"total"}), "total"]
            ),
        ]
    )


def losses(before: str | None, after: str | None) -> str:
    """Return the files that lost more than a point, with the lines that do not run."""
    then, now = _files(before), _files(after)
    lost = [
        f"{name}: {_share(then[name]):.1f} → {_share(now[name]):.1f} %, not run: {_ranges(now[name]['missing_lines'])}"
        for name in sorted(then.keys() & now.keys())
        if _share(then[name]) > _share(now[name]) + 1
    ]
    return "\n".join(["Files of which more than a point is lost:", *(lost or ["none"])])


def _files(commit: str | None) -> dict[str, Any]:
    report: dict[str, Any] = json.loads((RESULTS / (commit or "tree") / "coverage.json").read_text())
    return dict(report["files"])


def _ranges(lines: Sequence[int]) -> str:
    """Format lines as `3-5, 9`."""
    runs = [[at for _, at in run] for _, run in groupby(enumerate(lines), lambda each: each[1] - each[0])]
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)


def _by_package(files: dict[str, Any]) -> dict[str, dict[str, int]]:
    totals: dict[str, dict[str, int]] = defaultdict(lambda: defaultdict(int))
    for name, entry in files.items():
        parts = Path(name).parts
        package = parts[0] if parts[0] == "improv_ls" or len(parts) < 3 else parts[1]
        for total in (totals[package], totals["total"]):
            for key, value in entry["summary"].items():
                if isinstance(value, int):
                    total[key] += value
    return totals


def _shares(total: dict[str, int]) -> str:
    statements = 100 * total.get("covered_lines", 0) / max(total.get("num_statements", 0), 1)
    branches = 100 * total.get("covered_branches", 0) / max(total.get("num_branches", 0), 1)
    return f"{statements:>10.1f} %{branches:>8.1f} %"


def _share(file: dict[str, Any]) -> float:
    summary: dict[str, int] = file["summary"]
    return 100 * summary["covered_lines"] / max(summary["num_statements"], 1)
