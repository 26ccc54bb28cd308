"""Programs with a cursor in them, written `|>`."""

from __future__ import annotations

from textwrap import dedent

from improv_core.program.analysis import Analysis, analyze

CURSOR = "|>"


def at_cursor(program: str) -> tuple[Analysis, int]:
    """The analysis of the program without its cursor, and the cursor's offset."""
    program = dedent(program).strip("\n")
    offset = program.index(CURSOR)
    return analyze(program.replace(CURSOR, "")), offset
