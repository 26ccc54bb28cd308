"""Runs the tests against sixty faults of the core, and compares coverage before and after: see README.md."""

from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor

from tests.mutants.copies import RESULTS
from tests.mutants.coverage_map import Map, losses, measure, table
from tests.mutants.faults import FAULTS
from tests.mutants.meeting import Laboratory, Verdict


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.add_argument("--commit", help="of the tests and of what they test; the tree as it is if none is given")
    parser.add_argument("-j", type=int, default=2, dest="jobs", help="how many processes run tests")
    doing = parser.add_subparsers(dest="doing", required=True)
    doing.add_parser("map", help="run all tests once, and keep what each covers").add_argument("tests", nargs="*")
    doing.add_parser("coverage", help="compare two such runs").add_argument("before", help="a commit")
    meet = doing.add_parser("meet", help="have each fault meet the tests that run its lines, until one fails")
    meet.add_argument("--whole", action="store_true", help="those that survive meet all tests")
    meet.add_argument("files", nargs="*", help="only faults whose files' names contain one of these")
    asked = parser.parse_args()
    if asked.doing == "map":
        measure(asked.commit, asked.jobs, asked.tests)
        print(table(asked.commit))
        return 0
    if asked.doing == "coverage":
        print(table(asked.before, asked.commit), losses(asked.before, asked.commit), sep="\n\n")
        return 0
    return _meet(asked.commit, asked.jobs, asked.whole, asked.files)


def _meet(commit: str | None, jobs: int, whole: bool, files: list[str]) -> int:
    if not (RESULTS / (commit or "tree") / "map").exists():
        sys.exit(f"first: python -m tests.mutants{f' --commit {commit}' if commit else ''} map")
    faults = [fault for fault in FAULTS if not files or any(each in fault.file for each in files)]
    verdicts: list[Verdict] = []
    with Laboratory(commit, jobs, Map(commit)) as laboratory:
        fit = [fault for fault in faults if laboratory.fits(fault)]
        with ThreadPoolExecutor(jobs) as pool:
            for verdict in pool.map(lambda fault: laboratory.meet(fault, whole), fit):
                print(verdict, flush=True)
                verdicts.append(verdict)
        stale = [fault for fault in faults if fault not in fit]
    killed = sum(verdict.killer is not None for verdict in verdicts)
    print(f"\n{killed} of {len(verdicts)} were noticed: {100 * killed / max(len(verdicts), 1):.0f} %")
    for fault in stale:
        line = f"improv_core/{fault.file} has no longer, or not only once, {fault.original!r}"
        print(f"{line}: correct its row in tests/mutants/faults.py")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
