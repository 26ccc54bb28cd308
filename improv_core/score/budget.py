"""A limit for how much is computed at once. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass


class TooLongError(Exception):
    """Raised where something would take too long to compute."""


@dataclass(slots=True)
class Budget:
    """The steps that may still be computed."""

    left: int

    def spend(self, steps: int) -> None:
        """Raises TooLongError if there are not so many steps left."""
        self.left -= steps
        if self.left < 0:
            raise TooLongError

    def allow(self, steps: int) -> None:
        """Give up at once if so many steps are too many. Raises TooLongError."""
        if steps > self.left:
            raise TooLongError
