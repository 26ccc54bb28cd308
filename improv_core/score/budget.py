"""A limit for the work of one computation. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass

from improv_core.slices import checkpoint


class TooLongError(Exception):
    """Raised if something would take too long to compute."""


@dataclass(slots=True)
class Budget:
    """The steps that may still be computed."""

    left: int

    def spend(self, steps: int = 1) -> None:
        """Spend these steps. Raises TooLongError if fewer are left."""
        checkpoint()
        self.left -= steps
        if self.left < 0:
            raise TooLongError

    def allow(self, steps: int) -> None:
        """Raise TooLongError at once if these steps are too many."""
        if steps > self.left:
            raise TooLongError
