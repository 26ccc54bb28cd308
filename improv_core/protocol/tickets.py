"""Tickets: each opens the page once, so a URL that others can see, such as in the list of processes, is worthless.

The parent issues tickets, and the page's server redeems them for the token that both know: they need no message.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import os
import secrets
import time

ROOT = 0


def issue(token: str, *, own: bool = False) -> str:
    """Return a new ticket for a URL. One of our `own` opens the page only for this user, if the system lists users."""
    owner = os.getuid() if own and hasattr(os, "getuid") else ""
    about = f"{time.monotonic():.6f}-{secrets.token_hex(2)}-{owner}"
    return f"{about}-{_sign(token, about)}"


class Tickets:
    """The tickets of a server. Those from before it started count as used, because nothing remembers them."""

    def __init__(self, token: str) -> None:
        self._token = token
        self._started = time.monotonic()
        self._used: set[str] = set()

    def redeem(self, ticket: str, user: int | None) -> bool:
        """Use up a ticket if it is valid for a user (None: unknown). Return whether it was."""
        about, _, signature = ticket.rpartition("-")
        if not hmac.compare_digest(signature.encode(), _sign(self._token, about).encode()):
            return False
        issued, _, owner = about.split("-")
        if about in self._used or float(issued) < self._started:
            return False
        if owner and user not in (None, ROOT, int(owner)):  # root may be a relay, as in WSL
            return False
        self._used.add(about)
        return True


def _sign(token: str, about: str) -> str:
    """Sign with 96 bits: then the URL fits into a line of 80 columns, from which people copy it."""
    digest = hmac.new(token.encode(), about.encode(), hashlib.sha256).digest()
    return base64.b64encode(digest[:12], altchars=b"_~").decode()
