"""Tickets: each opens the page once, so a URL that others can see, such as in the list of processes, is soon worthless.

The parent issues tickets, and the page's server redeems them for the token that both know: no message is needed.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
import time


def issue(token: str) -> str:
    """A new ticket, for a URL."""
    about = f"{time.monotonic():.6f}-{secrets.token_hex(8)}"
    return f"{about}-{_sign(token, about)}"


class Tickets:
    """The tickets of a server. Those from before it started count as used, because nobody remembers them."""

    def __init__(self, token: str) -> None:
        self._token = token
        self._started = time.monotonic()
        self._used: set[str] = set()

    def redeem(self, ticket: str) -> bool:
        """Whether this ticket is valid; it never is again."""
        about, _, signature = ticket.rpartition("-")
        if not hmac.compare_digest(signature.encode(), _sign(self._token, about).encode()):
            return False
        if about in self._used or float(about.partition("-")[0]) < self._started:
            return False
        self._used.add(about)
        return True


def _sign(token: str, about: str) -> str:
    return hmac.new(token.encode(), about.encode(), hashlib.sha256).hexdigest()
