"""With which programs a performance exchanges OSC messages. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

SONIC_PI = 4560
"""The port on which Sonic Pi listens."""
HERE = "127.0.0.1"
"""Where only programs on this machine are heard."""


class Peer(NamedTuple):
    """A host, by its name or its IPv4 address, and a UDP port on it."""

    host: str
    port: int

    @property
    def is_here(self) -> bool:
        """Whether nothing that is sent between us leaves this machine."""
        return self.host == "localhost" or self.host.startswith("127.")

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class Osc:
    """Whom what plays is told to (`send`), and where requests are heard (`listen`; None: nowhere). With `time_tags`,
    what is told comes in bundles with the time at which it was due."""

    send: tuple[Peer, ...] = ()
    listen: Peer | None = None
    time_tags: bool = True

    @property
    def away(self) -> Peer | None:
        """The first address that isn't on this machine, or has other machines reach it."""
        return next((peer for peer in (self.listen, *self.send) if peer and not peer.is_here), None)
