"""The programs with which a performance exchanges OSC messages. Standard library only."""

from __future__ import annotations

import re
from dataclasses import dataclass
from ipaddress import AddressValueError, IPv4Address
from typing import NamedTuple

SONIC_PI = 4560
"""The port on which Sonic Pi listens."""
HERE = "127.0.0.1"
"""The address at which only programs on this machine reach us."""

LAST_PORT = 65535
_PEER = re.compile(r"([A-Za-z0-9][A-Za-z0-9.-]{0,252}):([0-9]{1,5})")


class Peer(NamedTuple):
    """A host, by its name or its IPv4 address, and a UDP port on it."""

    host: str
    port: int

    @property
    def is_here(self) -> bool:
        """True if no message between us and the peer leaves this machine."""
        return self.host == "localhost" or self.host.startswith("127.")

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class Osc:
    """The addresses to which messages about the performance go (`send`), and the one that receives requests (`listen`;
    None: none). With `time_tags`, messages go out in bundles with the time at which they were due."""

    send: tuple[Peer, ...] = ()
    listen: Peer | None = None
    time_tags: bool = True

    @property
    def away(self) -> Peer | None:
        """The first address that isn't on this machine, or that other machines can reach."""
        return next((peer for peer in (self.listen, *self.send) if peer and not peer.is_here), None)


def peer_of(text: str) -> Peer | None:
    """Return the peer that a text such as `127.0.0.1:9000` names."""
    form = _PEER.fullmatch(text)
    return Peer(form[1], int(form[2])) if form and 1 <= int(form[2]) <= LAST_PORT else None


def is_own(host: str) -> bool:
    """Return whether a text may be an address of this machine: an IPv4 address, or `localhost`."""
    try:
        return host == "localhost" or bool(IPv4Address(host))
    except AddressValueError:
        return False
