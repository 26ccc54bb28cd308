"""Code actions that fix diagnostics, one by one or all that are safe. (code_action_refactor.py has the others.)"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from improv_core.diagnostics import Diagnostic, Edit, Fix, Severity
from improv_core.ide.fragment import MAY_ITEMIZE, is_broken
from improv_core.program.analysis import Analysis
from improv_core.text import Span, difference

FIX_ALL = "source.fixAll.improv"
FIX_ALL_TITLE = "Fix all that is safe to fix"
REMOVABLE = frozenset({"never-performed", "unused-name", "duplicate-beat"})
"""Codes about text without effect. On request, all fixes that only remove such text are applied at once."""
_KEEP_THE_DANCE = frozenset({"never-performed", "unused-name", "no-effect"})
"""Codes below errors whose fixes keep the dance as it is."""
MAX_ROUNDS = 20
"""The most rounds of safe fixes: one error may hide the next one in its line."""


@dataclass(frozen=True, slots=True)
class Action:
    """Edits to apply together, in the order of the text.

    `kind` is one of LSP's: quickfix, refactor.extract, refactor.inline, refactor.rewrite, or one that begins with
    source.fixAll. `diagnostics` are those that it fixes. A `preferred` action is the only fix, and no guess.
    """

    title: str
    kind: str
    edits: tuple[Edit, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    preferred: bool = False


def fixes(diagnostics: Sequence[Diagnostic], span: Span) -> list[Action]:
    """Return the fixes for all diagnostics at a cursor or in a selection, and for all others of the same kind."""
    here = [each for each in diagnostics if each.span.start <= span.end and span.start <= each.span.end]
    found = [
        Action(fix.title, "quickfix", _ordered(fix.edits), (each,), _is_preferred(each))
        for each in here
        for fix in each.fixes
    ]
    fixable = {each.code: each for each in here if each.code in REMOVABLE and _removal(each)}
    return [*found, *(action for each in fixable.values() for action in _everywhere(diagnostics, each))]


def _is_preferred(problem: Diagnostic) -> bool:
    """Return whether the only fix of a problem is right. Below errors, it must keep the dance as it is."""
    if len(problem.fixes) != 1 or problem.fixes[0].guess:
        return False
    return problem.severity is Severity.ERROR or problem.fixes[0].safe or problem.code in _KEEP_THE_DANCE


def fix_all(analysis: Analysis) -> list[Action]:
    """Return the action that applies all safe fixes of a program, if there are any."""
    now = analysis
    for _ in range(MAX_ROUNDS):
        edits = _safe_edits(now)
        for edit in reversed(edits):
            now = now.edited(*edit.span, edit.text)
        if not edits:
            break
    if now.text == analysis.text:
        return []
    start, end, text = difference(analysis.text, now.text)
    return [Action(FIX_ALL_TITLE, FIX_ALL, (Edit(Span(start, end), text),))]


def _safe_edits(analysis: Analysis) -> Sequence[Edit]:
    """Return the edits of all safe fixes that do not touch each other, in the order of the text."""
    kept: list[Edit] = []
    for each in analysis.diagnostics:
        keeps = each.code != "no-effect" or _keeps_all(analysis, each)
        for fix in each.fixes:
            edits = _ordered(fix.edits)
            if fix.safe and keeps and not (kept and edits[0].span.start < kept[-1].span.end):
                kept += edits
                break
    return kept


def _keeps_all(analysis: Analysis, idle: Diagnostic) -> bool:
    """Return whether a word that has no effect can be removed. Words that count items also look into names: without
    `fast 1`, they would see the items after it. And the meaning of a line with an error is uncertain."""
    placed = analysis.statement_at(idle.span.start)
    return not MAY_ITEMIZE.search(analysis.text) and placed is not None and not is_broken(placed)


def _everywhere(diagnostics: Sequence[Diagnostic], problem: Diagnostic) -> Iterator[Action]:
    removals = [fix for each in diagnostics if each.code == problem.code and (fix := _removal(each))]
    if len(removals) > 1:
        edits = _apart(edit for fix in removals for edit in fix.edits)
        others = "the other one" if len(removals) == 2 else f"all {len(removals) - 1} others"
        yield Action(f"{removals[0].title} and {others} of this kind", "quickfix", edits, (problem,))


def _removal(problem: Diagnostic) -> Fix | None:
    """Return the fix that only removes text, if there is one."""
    return next((fix for fix in problem.fixes if not any(edit.text for edit in fix.edits)), None)


def _ordered(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    return tuple(sorted(edits, key=lambda edit: edit.span))


def _apart(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    """Return the edits in order, without those that overlap an earlier one."""
    kept: list[Edit] = []
    for edit in _ordered(edits):
        if not kept or edit.span.start >= kept[-1].span.end:
            kept.append(edit)
    return tuple(kept)
