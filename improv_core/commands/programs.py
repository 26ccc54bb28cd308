"""Programs named on the command line, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import FAILED, PROBLEMS, CommandError
from improv_core.program.analysis import Analysis
from improv_core.program.files import ReadError, analyze_file
from improv_core.program.report import as_lines


def report_each(files: Sequence[Path], report: Callable[[Path, Analysis], None]) -> int:
    """Report on every file that can be read; the exit code for the worst of them."""
    code = 0
    for path in files:
        try:
            analysis = analyze_file(path)
        except ReadError as problem:
            CommandError(str(problem)).show()
            code = FAILED
        else:
            report(path, analysis)
            code = max(code, 0 if analysis.ok else PROBLEMS)
    return code


def read_to_play(path: Path) -> Analysis | None:
    """The program in a file, or None if it has errors; its diagnostics go to stderr. Raises ReadError."""
    analysis = analyze_file(path)
    report_diagnostics(path, analysis)
    return analysis if analysis.ok else None


def report_diagnostics(path: Path, analysis: Analysis) -> None:
    """Print the diagnostics of a program to stderr, one per line."""
    for line in as_lines(path, analysis):
        echo(line, err=True)
