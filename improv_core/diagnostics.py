"""What can be wrong with a program: codes, how bad each is, and one plain line that says what to do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

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
}


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One mistake, at its exact place, in one line."""

    code: str
    span: Span
    message: str

    @property
    def severity(self) -> Severity:
        return SEVERITIES[self.code]

    def shifted(self, by: int) -> Diagnostic:
        return Diagnostic(self.code, self.span.shifted(by), self.message)
