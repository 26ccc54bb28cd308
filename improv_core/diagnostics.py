"""Diagnostics: problems of a program, their severity, and their fixes."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable
from difflib import get_close_matches
from enum import Enum

from improv_core.plain import message as in_plain_text
from improv_core.text import Span
from improv_core.values import value


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
    "missing-unit": Severity.ERROR,
    "wrong-measure": Severity.ERROR,
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
    "may-stall": Severity.INFORMATION,
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
    "too-sudden": Severity.WARNING,
    "too-short": Severity.WARNING,
    "too-far-back": Severity.INFORMATION,
    "never-performed": Severity.INFORMATION,
    "cut-short": Severity.INFORMATION,
    "unused-name": Severity.HINT,
    "no-effect": Severity.HINT,
    "bracket-not-a-beat": Severity.INFORMATION,
    "more-errors": Severity.ERROR,
    "more-hints": Severity.INFORMATION,
}

MAX_SHOWN = 500
"""The most diagnostics of one file that are shown; one more counts the rest. People fix a few at a time, and sending
all of 100,000 would delay every key."""


FADED = frozenset({"never-performed", "unused-name", "no-effect"})
"""Codes for text that has no effect. Editors fade it."""


@value(frozen=True, slots=True)
class Edit:
    """Replaces the text at `span`."""

    span: Span
    text: str


def applied(text: str, edits: Iterable[Edit]) -> str:
    """Return the text after edits that don't overlap."""
    parts, end = list[str](), 0
    for edit in sorted(edits, key=lambda each: each.span):
        parts += [text[end : edit.span.start], edit.text]
        end = edit.span.end
    return "".join([*parts, text[end:]])


@value(frozen=True, slots=True)
class Fix:
    """Edits that fix a problem, and a short title that describes them.

    A fix is `safe` if nobody needs to look at it: it has the only possible meaning or doesn't change the dance, and it
    removes no movement. Such fixes can be applied with every save. It is a `guess` if it writes an example or one of
    several possible meanings, so that somebody has to choose it.
    """

    title: str
    edits: tuple[Edit, ...]
    safe: bool = False
    guess: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "title", in_plain_text(self.title))

    def with_edits(self, edits: Iterable[Edit]) -> Fix:
        return Fix(self.title, tuple(edits), self.safe, self.guess)


@value(frozen=True, slots=True)
class Related:
    """Another span that a problem involves, and its role."""

    span: Span
    message: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "message", in_plain_text(self.message))


@value(frozen=True, slots=True)
class Diagnostic:
    """One problem at its exact span, described in one line, with fixes if they are obvious.

    A `doubtful` problem is only information, whatever its code: the program doesn't state all that it depends on. One
    that `warns` is only a warning: the program plays without the part that it is about. A message may quote anything
    from a file, so it is made printable here.
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
                [fix.with_edits([Edit(each.span.shifted(by), each.text) for each in fix.edits]) for fix in self.fixes]
            ),
            tuple([Related(other.span.shifted(by), other.message) for other in self.related]),
            self.doubtful,
            self.warns,
        )


def joining_nothing(text: str, problem: Diagnostic) -> Diagnostic:
    """Return a problem of a text, with fixes that join no names or numbers: a fix that removes everything visible
    between two of them leaves a space."""
    if all(_apart(text, each) is each for fix in problem.fixes for each in fix.edits):
        return problem  # true of most
    fixes = tuple([fix.with_edits([_apart(text, each) for each in fix.edits]) for fix in problem.fixes])
    return dataclasses.replace(problem, fixes=fixes)


def _apart(text: str, edit: Edit) -> Edit:
    start, end = edit.span
    gone, written = text[max(start, 0) : end], edit.text
    if start < 0 or not "".join(filter(str.isprintable, gone)).strip():
        return edit  # nothing visible kept the parts of a word, or a unit and its number, apart
    before, after = text[start - 1 : start] if start else "", text[end : end + 1]
    if not written:
        joins = (before == "." or _is_in_word(before)) and (after == "." or _is_in_word(after))
        return Edit(edit.span, " ") if joins else edit
    opens = _is_in_word(before) and _is_in_word(written[0]) and not (_is_in_word(gone[0]) or gone[0].isspace())
    last = gone[-1]  # after a digit, a name may follow at once: `0ft`
    ends = not (_is_in_word(last) or last.isspace()) or (last.isdigit() and not written[-1].isdigit())
    closes = _is_in_word(after) and _is_in_word(written[-1]) and ends
    return Edit(edit.span, f"{' ' * opens}{written}{' ' * closes}") if opens or closes else edit


def _is_in_word(char: str) -> bool:
    return char.isalnum() or char == "_"


def likely(word: str, known: Collection[str]) -> str | None:
    """Return the known word that was probably meant, if one is similar."""
    found = get_close_matches(word, known, n=1) or get_close_matches(word.lower(), known, n=1)
    return found[0] if found else None


def unknown(code: str, span: Span, message: str, near: str | None, otherwise: str) -> Diagnostic:
    """Return the diagnostic about an unknown word: it may be the word `near`; if there is none, do what follows."""
    hint = f"did you mean `{near}`?" if near else otherwise
    return Diagnostic(code, span, f"{message}: {hint}", replace(f"Change to {near}", span, near) if near else ())


def replace(title: str, span: Span, text: str, *, safe: bool = False, guess: bool = False) -> tuple[Fix, ...]:
    """Return a single fix that replaces the text at `span`."""
    return (Fix(title, (Edit(span, text),), safe, guess),)
