"""Findings of `improv doctor`: one line for each thing that it checks."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Mark(Enum):
    """State of something: it works, it is absent, it is broken."""

    GOOD = "✓"
    ABSENT = "–"
    BROKEN = "✗"


@dataclass(frozen=True, slots=True)
class Finding:
    """State of one thing, and what to do about it."""

    mark: Mark
    what: str
    advice: str = ""

    def __str__(self) -> str:
        return f"{self.mark.value} {self.what}" + (f": {self.advice}" if self.advice else "")


def good(what: str, advice: str = "") -> Finding:
    return Finding(Mark.GOOD, what, advice)


def absent(what: str, advice: str) -> Finding:
    return Finding(Mark.ABSENT, what, advice)


def broken(what: str, advice: str = "") -> Finding:
    return Finding(Mark.BROKEN, what, advice)
