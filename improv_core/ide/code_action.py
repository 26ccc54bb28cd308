"""Code actions that fix diagnostics. (code_action_refactor.py has the others.)"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from improv_core.diagnostics import Diagnostic, Edit
from improv_core.program.analysis import Analysis
from improv_core.text import Span

SAFE = frozenset({"never-performed", "unused-name", "duplicate-beat"})
"""Codes whose fixes only remove text without effect, so all of them can be applied at once."""


@dataclass(frozen=True, slots=True)
class Action:
    """Edits to apply together, in the order of the text.

    `kind` is one of LSP's: quickfix, refactor.extract, refactor.inline, or refactor.rewrite. `diagnostics` are those
    that it fixes. `preferred` says that it is the only fix.
    """

    title: str
    kind: str
    edits: tuple[Edit, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    preferred: bool = False


def fixes(analysis: Analysis, span: Span) -> list[Action]:
    """The fixes for all diagnostics at a cursor or in a selection, and for all others of the same kind."""
    here = [each for each in analysis.diagnostics if each.span.start <= span.end and span.start <= each.span.end]
    found = [
        Action(fix.title, "quickfix", _ordered(fix.edits), (each,), len(each.fixes) == 1)
        for each in here
        for fix in each.fixes
    ]
    fixable = {each.code: each for each in here if each.code in SAFE and each.fixes}
    return [*found, *(action for each in fixable.values() for action in _everywhere(analysis, each))]


def _everywhere(analysis: Analysis, problem: Diagnostic) -> Iterator[Action]:
    alike = [each for each in analysis.diagnostics if each.code == problem.code and each.fixes]
    if len(alike) > 1:
        edits = _apart(edit for each in alike for edit in each.fixes[0].edits)
        others = "the other one" if len(alike) == 2 else f"all {len(alike) - 1} others"
        yield Action(f"{problem.fixes[0].title} and {others} of this kind", "quickfix", edits, (problem,))


def _ordered(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    return tuple(sorted(edits, key=lambda edit: edit.span))


def _apart(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    """The edits in order, without those that overlap an earlier one."""
    kept: list[Edit] = []
    for edit in _ordered(edits):
        if not kept or edit.span.start >= kept[-1].span.end:
            kept.append(edit)
    return tuple(kept)
