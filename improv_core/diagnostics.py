"""What can be wrong with a program: codes, how bad each is, and one plain line that says what to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from improv_core.plain import message as in_plain_text
from improv_core.text import Span


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"
    INFORMATION = "information"
    HINT = "hint"


SEVERITIES = {
    "syntax": Severity.ERROR,
    "unclosed-bracket": Severity.ERROR,
    "unmatched-bracket": Severity.ERROR,
    "unknown-name": Severity.ERROR,
    "used-before-definition": Severity.ERROR,
    "reserved-name": Severity.ERROR,
    "bad-number": Severity.ERROR,
    "duplicate-beat": Severity.ERROR,
    "bad-robot-name": Severity.ERROR,
    "endless-reverse": Severity.ERROR,
    "too-deep": Severity.ERROR,
    "empty-group": Severity.WARNING,
    "robots": Severity.ERROR,
    "unknown-robot": Severity.ERROR,
    "unsupported-direction": Severity.ERROR,
    "too-fast": Severity.WARNING,
    "too-short": Severity.WARNING,
    "never-performed": Severity.HINT,
    "unused-name": Severity.HINT,
    "bracket-not-a-beat": Severity.INFORMATION,
    "more-errors": Severity.ERROR,
    "more-hints": Severity.INFORMATION,
}

MOST_SHOWN = 500
"""Diagnostics of one file that are shown; one more says how much they leave out. People fix a few at a time, and all of
100,000 would hold up every key."""


FADED = frozenset({"never-performed", "unused-name"})
"""Codes of what does nothing; editors draw it faded."""


@dataclass(frozen=True, slots=True)
class Edit:
    """A text to put in place of what stands at `span`."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Fix:
    """Edits that fix an error, and what they do in a few words."""

    title: str
    edits: tuple[Edit, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "title", in_plain_text(self.title))


@dataclass(frozen=True, slots=True)
class Related:
    """Another place that an error involves, and how."""

    span: Span
    message: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", in_plain_text(self.message))


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One error or hint, at its exact place, in one line, and the fixes that are obvious.

    What a message quotes from a file may be anything: it is made plain here, so that no message can forget to.
    """

    code: str
    span: Span
    message: str
    fixes: tuple[Fix, ...] = ()
    related: tuple[Related, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", in_plain_text(self.message))

    @property
    def severity(self) -> Severity:
        return SEVERITIES[self.code]

    def shifted(self, by: int) -> Diagnostic:
        return Diagnostic(
            self.code,
            self.span.shifted(by),
            self.message,
            tuple(
                Fix(fix.title, tuple(Edit(edit.span.shifted(by), edit.text) for edit in fix.edits))
                for fix in self.fixes
            ),
            tuple(Related(other.span.shifted(by), other.message) for other in self.related),
        )


def replace(title: str, span: Span, text: str) -> tuple[Fix, ...]:
    """The one fix that puts a text in place of another."""
    return (Fix(title, (Edit(span, text),)),)
