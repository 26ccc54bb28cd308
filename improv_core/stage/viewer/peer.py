"""Which user of this computer is at the other end of a connection."""

from __future__ import annotations

from pathlib import Path
from socket import inet_aton

TABLE = Path("/proc/net/tcp")
"""Linux's table of TCP connections over IPv4."""


def user_of(peer: tuple[str, int], own: tuple[str, int]) -> int | None:
    """The number of the user who connected from `peer` to `own`; None if the system does not tell."""
    wanted = [_in_hex(peer), _in_hex(own)]
    try:
        rows = [row.split() for row in TABLE.read_text(encoding="ascii").splitlines()]
    except OSError:
        return None
    # Columns: number, the connection's own address, the other one's, state, queues, timer, retransmits, user.
    return next((int(row[7]) for row in rows if row[1:3] == wanted), None)


def _in_hex(address: tuple[str, int]) -> str:
    """127.0.0.1 port 80 is 0100007F:0050 (on the usual little-endian processors)."""
    host, port = address[:2]
    return f"{inet_aton(host)[::-1].hex().upper()}:{port:04X}"
