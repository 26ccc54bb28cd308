"""This computer: its own address, and the user of it at the other end of a connection."""

from __future__ import annotations

import re
import socket
from contextlib import suppress
from pathlib import Path

HOST = "127.0.0.1"
"""The address on which pages are served: no other machine can reach it."""
OWN_HOST = re.compile(r"(127\.0\.0\.1|localhost):\d+")
"""The hosts that a page of this machine asks. Another website may point a name of its own at this machine, so no other
names are answered. The port may be any: an editor brings the page to its window through a tunnel."""
TABLES = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))
"""Linux's tables of TCP connections, over IPv4 and over IPv6."""
MAPPED = "0000000000000000FFFF0000"
"""Beginning of an IPv6 address that stands for an IPv4 address: ::ffff:127.0.0.1 connects to 127.0.0.1."""
ESTABLISHED = "01"
NOBODY = -1
"""The system lists the users of connections, but no user has this one."""


def listen(usual_port: int) -> socket.socket:
    """Listen on this port, or on any free one if it is taken: a browser knows again what it kept of the same port."""
    with suppress(OSError):
        return socket.create_server((HOST, usual_port))
    return socket.create_server((HOST, 0))


def user_of(peer: tuple[str, int], own: tuple[str, int]) -> int | None:
    """Return the number of the user who connected from `peer` to `own`; `NOBODY` if there is none, and None if the
    system doesn't list users."""
    wanted = [_in_hex(peer), _in_hex(own)]
    mapped = [MAPPED + address for address in wanted]
    told = False
    for table in TABLES:
        try:
            rows = [row.split() for row in table.read_text(encoding="ascii").splitlines()[1:]]
        except OSError:
            continue
        told = told or bool(rows)
        # Columns: number, the connection's own address, the address of the other end, state, queues, timer,
        # retransmits, user. A connection that its process has closed is listed as root's.
        for row in rows:
            if row[1:3] in (wanted, mapped) and row[3] == ESTABLISHED:
                return int(row[7])
    return NOBODY if told else None


def _in_hex(address: tuple[str, int]) -> str:
    """Format an address as these tables do: 127.0.0.1 port 80 is 0100007F:0050 (on the usual little-endian
    processors)."""
    host, port = address[:2]
    return f"{socket.inet_aton(host)[::-1].hex().upper()}:{port:04X}"
