"""Findings of `improv doctor`: one line for each thing that it checks."""

from __future__ import annotations

from dataclasses import dataclass

GOOD, ABSENT, BROKEN = "✓", "–", "✗"
"""States of something: it works, it is absent, it is broken."""


@dataclass(frozen=True, slots=True)
class Finding:
    """State of one thing, and what to do about it."""

    mark: str
    what: str
    advice: str = ""

    def __str__(self) -> str:
        return f"{self.mark} {self.what}" + (f": {self.advice}" if self.advice else "")


def good(what: str, advice: str = "") -> Finding:
    return Finding(GOOD, what, advice)


def absent(what: str, advice: str) -> Finding:
    return Finding(ABSENT, what, advice)


def broken(what: str, advice: str = "") -> Finding:
    return Finding(BROKEN, what, advice)
