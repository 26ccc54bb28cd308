"""What a stop makes void once it has overtaken it, and what waits for a stop that it has overtaken: pure decisions,
without a clock."""

from __future__ import annotations

from dataclasses import dataclass, replace

from improv_core.protocol.commands import VOID


@dataclass(frozen=True, slots=True)
class Overtaking:
    """What has come on the channel of stops, where stops, pauses, and pings are numbered together.

    Whatever comes by standard input says which of them was the latest before it.
    """

    heard: int = 0
    """The number of the latest."""
    void: int = 0
    """Requests that were sent after fewer of them than this are void."""

    def hear(self, kind: str, number: int) -> Overtaking:
        """One more has come."""
        heard = max(self.heard, number)
        return Overtaking(heard, self.void if kind == "ping" else max(self.void, number))

    def lose(self) -> Overtaking:
        """Nothing has come for so long that the robots were stopped: what was sent until now must not move them."""
        return replace(self, void=self.heard + 1) if self.heard else self

    def voids(self, kind: str, after: int | None) -> bool:
        """Whether a request that was sent after this many must not be obeyed; None if nobody counts."""
        return kind in VOID and after is not None and after < self.void

    def awaits(self, kind: str, after: int | None) -> bool:
        """Whether a request was sent after something that has yet to come here, by another pipe: perhaps a stop, which
        must not stop what people asked for after it, or the first sign of life of a parent that had hung."""
        return kind in VOID and after is not None and after > self.heard
