"""`improv format`: the standard layout, for programs in files and in the code blocks of Markdown files."""

from __future__ import annotations

import difflib
import re
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo, echo_text
from improv_core.commands.exit_codes import FAILED, PROBLEMS, CommandError
from improv_core.commands.programs import files_in
from improv_core.plain import printable
from improv_core.program.files import ENDING, STANDARD_INPUT, ReadError, read_program
from improv_core.storage.atomic_write import why
from improv_core.storage.compare_and_swap import swap_text
from improv_core.syntax.formatter import format_text

PAGES = ".md"
# Every fenced block, so that a fence shown inside a longer one does not count as a block.
_BLOCK = re.compile(
    r"^(?P<head>(?P<indent>[ \t]*)(?P<fence>`{3,}|~{3,})(?P<language>[^`\r\n]*)\r?\n)"
    r"(?P<code>.*?)(?P<foot>^[ \t]*(?P=fence)[`~]*[ \t]*\r?$)",
    re.MULTILINE | re.DOTALL,
)


@click.command("format")
@parameters.files
@click.option("--check", is_flag=True, help="Write nothing; list the files that would change. Exit code 1 if any.")
@click.option("--diff", is_flag=True, help="Write nothing; show the changes.")
def command(files: tuple[Path, ...], check: bool, diff: bool) -> None:
    """Format programs.

    FILES are programs, Markdown files with code blocks, folders of both, or - for standard input, which is printed.
    """
    sys.exit(format_files(files, check=check, diff=diff))


def format_files(paths: Sequence[Path], *, check: bool, diff: bool) -> int:
    """Format files, and all programs and Markdown files in folders, and print the results. Return the exit code.

    Raises ReadError if a folder has none.
    """
    code = 0
    for path in files_in(paths, ENDING, PAGES):
        try:
            if path != STANDARD_INPUT and path.suffix not in (ENDING, PAGES):
                raise ReadError(f"{path}: it was not changed: only {ENDING} and {PAGES} files are formatted")
            text = read_program(path)
            formatted = _BLOCK.sub(_block, text) if path.suffix == PAGES else format_text(text)
            if path == STANDARD_INPUT and not check and not diff:
                echo_text(formatted)
                continue
            if formatted == text:
                continue
            if diff:
                _print_diff(path, text, formatted)
            if check:
                echo(f"would format {path}")
                code = max(code, PROBLEMS)
            elif not diff:
                _rewrite(path, text, formatted)
                echo(f"formatted {path}")
        except (ReadError, CommandError) as problem:
            CommandError(str(problem)).show()
            code = FAILED
    return code


def _block(block: re.Match[str]) -> str:
    """Format a fenced block at the indentation of its fence if it holds Improv."""
    indent = block["indent"]
    hanging = re.search(rf"^(?!{indent}|\r?$)", block["code"].removesuffix("\n"), re.MULTILINE) if indent else None
    if block["language"].strip() != "improv" or hanging:
        return block[0]
    code = format_text(re.sub(rf"^{indent}", "", block["code"], flags=re.MULTILINE))
    return block["head"] + re.sub(r"^(?=[^\r\n])", indent, code, flags=re.MULTILINE) + block["foot"]


def _print_diff(path: Path, before: str, after: str) -> None:
    """Print a diff: in a terminal as printable text, elsewhere exactly, so that `patch` can read it."""
    in_terminal = sys.stdout.isatty()
    for line in difflib.unified_diff(_file_lines(before), _file_lines(after), str(path), f"{path} (formatted)"):
        text = line.removesuffix("\n")
        click.echo(printable(text.removesuffix("\r")) if in_terminal else text, color=True)
        if text == line:
            click.echo("\\ No newline at end of file")


def _file_lines(text: str) -> list[str]:
    return re.findall(r"[^\n]*\n|[^\n]+", text)


def _rewrite(path: Path, before: str, after: str) -> None:
    """Replace the content of a file, if that is still the text that was read. Raises CommandError."""
    try:
        if not swap_text(path, before, after):
            raise CommandError(f"{path}: it changed while it was being formatted: run this again")
    except OSError as error:
        raise CommandError(f"{path}: {why(error)}") from None
