"""Prepares programs, or parts of them, to be played: a pure function, which may take long."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from improv_core.diagnostics import Severity
from improv_core.ide.selection import Selection, UnplayableError
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.report import summary
from improv_core.score.score import Score
from improv_ls.documents import Document

Choose: TypeAlias = Callable[[Analysis], Selection]
"""Selects a part of a program. Raises UnplayableError."""


class PreparedProgram(NamedTuple):
    """A document whose analysis plays only the selection, its score, and a line that sums it up."""

    document: Document
    only: Selection
    score: Score
    line: str


def prepare(document: Document, choose: Choose | None) -> PreparedProgram:
    """Prepare a part of a document, or without a choice all of it. Raises UnplayableError with a reason in one line."""
    only = choose(document.analysis) if choose else Selection("", document.analysis)
    if why := refusal(document, whole=choose is None):
        raise UnplayableError(why)
    line = f"{only.name}: {summary(only.analysis)}" if only.name else summary(only.analysis)
    return PreparedProgram(replace(document, analysis=only.analysis), only, score_of(only.analysis), line)


def among(prepared: PreparedProgram, score: Score, before: Selection) -> PreparedProgram:
    """Return a part of a program that plays as this score, which may also have robots of the selection `before` it."""
    only, others = prepared.only, score.parts.keys() - prepared.score.parts.keys()
    ghost = only.ghost or (before.ghost if before.ghost in others else None)
    both = replace(only, ghost=ghost, moved=only.moved or (before.moved and bool(others)))
    return prepared._replace(score=score, only=both)


def refusal(document: Document, *, whole: bool) -> str | None:
    """Return why no robot may move because of `improv.toml` or, if the whole program is to play, of its errors."""
    analysis = document.analysis
    if not analysis.config.ok:
        # Without a text, editors can't show the errors.
        return "improv.toml has errors" if analysis.config.text else analysis.config.diagnostics[0].message
    errors = [each for each in analysis.diagnostics if each.severity is Severity.ERROR] if whole else []
    if not errors:
        return None
    line = document.lines.number(errors[0].span.start)
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"line {line}: {errors[0].message}{more}"
