"""Programs and `improv.toml` files named on the command line, and their errors."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import FAILED, PROBLEMS, CommandError
from improv_core.program.analysis import Analysis
from improv_core.program.files import ReadError, analyze_file, robots_in
from improv_core.program.report import as_lines
from improv_core.robots.config import FILE_NAME, Robots
from improv_core.storage.atomic_write import why
from improv_core.storage.compare_and_swap import swap


def read_each(named: Sequence[Path], *endings: str) -> Iterator[tuple[Path, Analysis | Robots | None]]:
    """Yield the named files, and those of `files_in`: programs, and each `improv.toml` if it is among the endings; None
    for a file that can't be read, whose problem is printed. Raises ReadError as `files_in` does."""
    for path in files_in(named, *endings):
        try:
            yield path, robots_in(path) if path.name == FILE_NAME in endings else analyze_file(path)
        except ReadError as problem:
            CommandError(str(problem)).show()
            yield path, None


def code_of(found: Analysis | Robots | None) -> int:
    """Return the exit code of a command that found this, and nothing worse."""
    return FAILED if found is None else 0 if found.ok else PROBLEMS


def files_in(named: Sequence[Path], *endings: str) -> Sequence[Path]:
    """Return the named files, and in named folders the files with such an ending or name that are not hidden; each
    once.

    Raises ReadError if a folder can't be read or has none.
    """
    return list(dict.fromkeys(file for path in named for file in (_files(path, endings) if path.is_dir() else [path])))


def _files(top: Path, endings: tuple[str, ...]) -> Sequence[Path]:
    def fail(error: OSError) -> None:
        raise ReadError(f"{error.filename}: {(error.strerror or 'it cannot be read').lower()}")

    found: list[Path] = []
    for folder, folders, names in os.walk(top, onerror=fail):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        found.extend(
            Path(folder, name)
            for name in sorted(names)
            if name in endings or (name[0] != "." and Path(name).suffix in endings)
        )
    if not found:
        what = f"no files that end in {' or '.join(each for each in endings if each[0] == '.')}"
        raise ReadError(f"{top}: it has {what}{f', and no {FILE_NAME}' if FILE_NAME in endings else ''}")
    return found


def exists_already(path: Path) -> CommandError:
    """Return the error about a file that is not to be overwritten."""
    return CommandError(f"{path} exists already: name a new file")


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet. Raises CommandError."""
    try:
        if not swap(path, None, text.encode()):
            raise exists_already(path)
    except OSError as error:
        raise CommandError(f"{path}: {why(error)}") from None


def read_to_play(path: Path) -> Analysis | None:
    """Read the program in a file; None if it has errors. Its diagnostics go to stderr. Raises ReadError."""
    analysis = analyze_file(path)
    report_diagnostics(path, analysis)
    return analysis if analysis.ok else None


def report_diagnostics(path: Path, analysis: Analysis) -> None:
    """Print the diagnostics of a program to stderr, one per line."""
    for line in as_lines(path, analysis):
        echo(line, err=True)
