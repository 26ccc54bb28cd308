"""The times in messages, by the clock that shows them: so another machine can translate them. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

Clock = Literal["monotonic", "unix", "unix_nanoseconds", "asleep"]


@dataclass(frozen=True, slots=True)
class TimeOn:
    """Marks a time on a machine's clock: `Annotated[float, TimeOn("monotonic")]`."""

    clock: Clock

    def holds(self, value: object) -> bool:
        """Return True: any number may be a time."""
        return True


Monotonic = Annotated[float, TimeOn("monotonic")]
"""Seconds."""
UnixTime = Annotated[float, TimeOn("unix")]
"""Seconds."""
UnixNanoseconds = Annotated[int, TimeOn("unix_nanoseconds")]
Asleep = Annotated[float, TimeOn("asleep")]
"""The seconds that a machine has slept."""
