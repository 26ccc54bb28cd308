"""What `improv doctor` reports: one line for each thing it looked at."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Mark(Enum):
    """The state of something: it works, it is absent, it is broken."""

    GOOD = "✓"
    ABSENT = "–"
    BROKEN = "✗"


@dataclass(frozen=True, slots=True)
class Finding:
    """The state of one thing, and what to do about it."""

    mark: Mark
    what: str
    advice: str = ""

    def __str__(self) -> str:
        return f"{self.mark.value} {self.what}" + (f": {self.advice}" if self.advice else "")
