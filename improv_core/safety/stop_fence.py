"""Decides which requests a stop makes void when it overtakes them, and which requests have to wait for a stop that they
have overtaken. Pure decisions, without a clock."""

from __future__ import annotations

from dataclasses import dataclass, replace

from improv_core.protocol.commands import VOIDED_BY_STOP

MOST = 64
"""The stops that have come straight to a stage and are remembered."""


@dataclass(frozen=True, slots=True)
class StopFence:
    """The messages that have come on the channel of stops, where stops, pauses, and pings share one numbering.

    Each message on standard input names the latest of these numbers that was sent before it.
    """

    heard: int = 0
    """The highest number so far."""
    void: int = 0
    """A request is void if the latest number before it is less than this."""
    direct: frozenset[str] = frozenset()
    """The stops that have come straight here, and that the parent has yet to send. Until it has sent each, it may not
    have known of it, so all of its requests are void, whatever their numbers."""
    known: tuple[str, ...] = ()
    """The latest stops of that kind that the parent has sent."""

    def hear(self, kind: str, number: int) -> StopFence:
        """Return it after another message has come."""
        heard = max(self.heard, number)
        return replace(self, heard=heard, void=self.void if kind == "ping" else max(self.void, number))

    def hear_direct(self, stop: str) -> StopFence:
        """Return it after a stop has come straight here. In a flood, those that wait already keep the fence closed."""
        waits = stop not in self.known and len(self.direct) < MOST
        return replace(self, direct=self.direct | {stop}) if waits else self

    def has(self, stop: str) -> bool:
        """Return whether this stop has come straight here, or from the parent."""
        return stop in self.direct or stop in self.known

    def settle(self, stop: str) -> StopFence:
        """Return it after the parent has sent this stop, too: what it sends from now on was requested later."""
        return replace(self, direct=self.direct - {stop}, known=(*self.known, stop)[-MOST:])

    def lose(self) -> StopFence:
        """Return it after robots were stopped because nothing has come for too long: requests sent until now must not
        move them."""
        return replace(self, void=self.heard + 1) if self.heard else self

    def voids(self, kind: str, after: int | None) -> bool:
        """Return whether a request that was sent after this number must not be obeyed. `after` is None if nobody
        counts."""
        return kind in VOIDED_BY_STOP and (bool(self.direct) or (after is not None and after < self.void))

    def awaits(self, kind: str, after: int | None) -> bool:
        """Return whether a request was sent after a message that has yet to come here, by the other pipe. That may be a
        stop, which must not stop what people asked for after it, or the first ping of a parent that had hung."""
        return kind in VOIDED_BY_STOP and after is not None and after > self.heard
