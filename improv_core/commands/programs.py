"""Programs named on the command line, and what is wrong with them."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import FAILED, PROBLEMS, CommandError
from improv_core.program.analysis import Analysis
from improv_core.program.files import ENDING, ReadError, analyze_file
from improv_core.program.report import as_lines


def report_each(named: Sequence[Path], report: Callable[[Path, Analysis], None]) -> int:
    """Report on every program that can be read, also in folders; the exit code for the worst of them.

    Raises ReadError if a folder has none.
    """
    code = 0
    for path in files_in(named, ENDING):
        try:
            analysis = analyze_file(path)
        except ReadError as problem:
            CommandError(str(problem)).show()
            code = FAILED
        else:
            report(path, analysis)
            code = max(code, 0 if analysis.ok else PROBLEMS)
    return code


def files_in(named: Sequence[Path], *endings: str) -> Sequence[Path]:
    """The files that are named, and in named folders those with such an ending that are not hidden; each once.

    Raises ReadError if a folder can't be read or has none.
    """
    return list(dict.fromkeys(file for path in named for file in (_files(path, endings) if path.is_dir() else [path])))


def _files(top: Path, endings: tuple[str, ...]) -> Sequence[Path]:
    def fail(error: OSError) -> None:
        raise ReadError(f"{error.filename}: {(error.strerror or 'it cannot be read').lower()}")

    found: list[Path] = []
    for folder, folders, names in os.walk(top, onerror=fail):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found.extend(Path(folder, name) for name in sorted(names) if name.endswith(endings) and name[0] != ".")
    if not found:
        raise ReadError(f"{top}: it has no files that end in {' or '.join(endings)}")
    return found


def read_to_play(path: Path) -> Analysis | None:
    """The program in a file, or None if it has errors; its diagnostics go to stderr. Raises ReadError."""
    analysis = analyze_file(path)
    report_diagnostics(path, analysis)
    return analysis if analysis.ok else None


def report_diagnostics(path: Path, analysis: Analysis) -> None:
    """Print the diagnostics of a program to stderr, one per line."""
    for line in as_lines(path, analysis):
        echo(line, err=True)
