"""Reasons why a program can't play, in one line."""

from __future__ import annotations

from improv_core.diagnostics import Severity
from improv_ls.documents import Document


def refusal(document: Document) -> str | None:
    """Return why a whole program can't play; None if it can."""
    if why := wrong_robots(document):
        return why
    errors = [each for each in document.analysis.diagnostics if each.severity is Severity.ERROR]
    if not errors:
        return None
    line = document.lines.position(errors[0].span.start).line + 1
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"line {line}: {errors[0].message}{more}"


def wrong_robots(document: Document) -> str | None:
    """Return why no robot may move; None if improv.toml has no error."""
    config = document.analysis.config
    if config.ok:
        return None
    # Without a text, editors can't show the errors.
    return "improv.toml has errors" if config.text else config.diagnostics[0].message
