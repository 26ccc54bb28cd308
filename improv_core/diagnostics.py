"""Diagnostics: what is wrong with a program, how severe it is, and how to fix it."""

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
    "duplicate-line": Severity.ERROR,
    "bad-robot-name": Severity.ERROR,
    "endless-reverse": Severity.ERROR,
    "too-deep": Severity.ERROR,
    "arguments": Severity.ERROR,
    "too-large": Severity.ERROR,
    "open-length": Severity.ERROR,
    "uneven-choice": Severity.ERROR,
    "misplaced-canon": Severity.ERROR,
    "unknown-sense": Severity.ERROR,
    "instant-sense": Severity.ERROR,
    "missing-sense": Severity.WARNING,
    "looks-ahead": Severity.WARNING,
    "nothing-near": Severity.INFORMATION,
    "short-reach": Severity.INFORMATION,
    "duplicate-parameter": Severity.ERROR,
    "parameter-kind": Severity.ERROR,
    "empty-group": Severity.WARNING,
    "robots": Severity.ERROR,
    "unknown-robot": Severity.ERROR,
    "unknown-profile": Severity.ERROR,
    "other-profile": Severity.WARNING,
    "meets": Severity.WARNING,
    "hits": Severity.WARNING,
    "robot-named-and": Severity.INFORMATION,
    "near-name": Severity.INFORMATION,
    "two-spellings": Severity.WARNING,
    "unsupported-direction": Severity.ERROR,
    "pose-reversed": Severity.ERROR,
    "misplaced-pose": Severity.ERROR,
    "no-such-pose": Severity.ERROR,
    "no-such-part": Severity.WARNING,
    "part-direction": Severity.WARNING,
    "pose-disturbed": Severity.WARNING,
    "joint-limit": Severity.WARNING,
    "too-fast": Severity.WARNING,
    "too-short": Severity.WARNING,
    "never-performed": Severity.INFORMATION,
    "unused-name": Severity.HINT,
    "no-effect": Severity.HINT,
    "bracket-not-a-beat": Severity.INFORMATION,
    "more-errors": Severity.ERROR,
    "more-hints": Severity.INFORMATION,
}

MOST_SHOWN = 500
"""Diagnostics of one file that are shown; one more says how much they leave out. People fix a few at a time, and all of
100,000 would hold up every key."""


FADED = frozenset({"never-performed", "unused-name", "no-effect"})
"""Codes for text that has no effect. Editors fade it."""


@dataclass(frozen=True, slots=True)
class Edit:
    """Replaces the text at `span`."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Fix:
    """Edits that fix a problem, and a short title that says what they do.

    A fix is `safe` if nobody needs to look at it: nothing else can be meant, or it changes nothing that is played, and
    it removes no movement. Such fixes can be applied with every save. It is a `guess` if it writes an example, or
    one of several things that may be meant, so that somebody has to choose it.
    """

    title: str
    edits: tuple[Edit, ...]
    safe: bool = False
    guess: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "title", in_plain_text(self.title))


@dataclass(frozen=True, slots=True)
class Related:
    """Another span that a problem involves, and how."""

    span: Span
    message: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", in_plain_text(self.message))


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One problem at its exact span, described in one line, with fixes if they are obvious.

    If it is `doubtful`, it is only information, whatever its code: the program doesn't say all that it depends on. If
    it `warns`, it is only a warning: the program plays without what it is about. A
    message may quote anything from a file. It is made printable here, so that no message can forget to.
    """

    code: str
    span: Span
    message: str
    fixes: tuple[Fix, ...] = ()
    related: tuple[Related, ...] = ()
    doubtful: bool = False
    warns: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", in_plain_text(self.message))

    @property
    def severity(self) -> Severity:
        if self.warns:
            return Severity.WARNING
        return Severity.INFORMATION if self.doubtful else SEVERITIES[self.code]

    def shifted(self, by: int) -> Diagnostic:
        return Diagnostic(
            self.code,
            self.span.shifted(by),
            self.message,
            tuple(
                Fix(fix.title, tuple(Edit(edit.span.shifted(by), edit.text) for edit in fix.edits), fix.safe, fix.guess)
                for fix in self.fixes
            ),
            tuple(Related(other.span.shifted(by), other.message) for other in self.related),
            self.doubtful,
            self.warns,
        )


def replace(title: str, span: Span, text: str, *, safe: bool = False, guess: bool = False) -> tuple[Fix, ...]:
    """A single fix that replaces the text at `span`."""
    return (Fix(title, (Edit(span, text),), safe, guess),)
