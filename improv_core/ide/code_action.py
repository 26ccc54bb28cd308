"""Code actions that fix diagnostics. (code_action_refactor.py has the others.)"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from improv_core.diagnostics import Diagnostic, Edit, Fix
from improv_core.text import Span

SAFE = frozenset({"never-performed", "unused-name", "duplicate-beat"})
"""Codes of text without effect. Their fixes that only remove it can all be applied at once."""


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


def fixes(diagnostics: Sequence[Diagnostic], span: Span) -> list[Action]:
    """The fixes for all diagnostics at a cursor or in a selection, and for all others of the same kind."""
    here = [each for each in diagnostics if each.span.start <= span.end and span.start <= each.span.end]
    found = [
        Action(fix.title, "quickfix", _ordered(fix.edits), (each,), len(each.fixes) == 1)
        for each in here
        for fix in each.fixes
    ]
    fixable = {each.code: each for each in here if each.code in SAFE and _removal(each)}
    return [*found, *(action for each in fixable.values() for action in _everywhere(diagnostics, each))]


def _everywhere(diagnostics: Sequence[Diagnostic], problem: Diagnostic) -> Iterator[Action]:
    removals = [fix for each in diagnostics if each.code == problem.code and (fix := _removal(each))]
    if len(removals) > 1:
        edits = _apart(edit for fix in removals for edit in fix.edits)
        others = "the other one" if len(removals) == 2 else f"all {len(removals) - 1} others"
        yield Action(f"{removals[0].title} and {others} of this kind", "quickfix", edits, (problem,))


def _removal(problem: Diagnostic) -> Fix | None:
    """The fix that only removes text, if there is one."""
    return next((fix for fix in problem.fixes if not any(edit.text for edit in fix.edits)), None)


def _ordered(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    return tuple(sorted(edits, key=lambda edit: edit.span))


def _apart(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    """The edits in order, without those that overlap an earlier one."""
    kept: list[Edit] = []
    for edit in _ordered(edits):
        if not kept or edit.span.start >= kept[-1].span.end:
            kept.append(edit)
    return tuple(kept)
