"""Programs with a cursor in them, written `|>`, and the effect of keys on them."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import dedent

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import fixes
from improv_core.program.analysis import Analysis, analyze

CURSOR = "|>"


def at_cursor(program: str) -> tuple[Analysis, int]:
    """Return the analysis of the program without its cursor, and the cursor's offset."""
    program = dedent(program).strip("\n")
    offset = program.index(CURSOR)
    return analyze(program.replace(CURSOR, "")), offset


def preferred(analysis: Analysis) -> list[Sequence[Edit]]:
    """Return all edits that the key for the preferred fix may make, at any place."""
    every = (action for each in analysis.diagnostics for action in fixes(analysis.diagnostics, each.span))
    return list(dict.fromkeys(action.edits for action in every if action.preferred))
