"""The zeros at the end of a robot's motion. Standard library only."""

from __future__ import annotations

LAST_ZEROS = 3
"""The number of zeros that end a robot's motion. One may be lost, but an endless stream would conflict with other
publishers."""
LINGER = 0.2
"""Seconds for which a publisher stays after its last zero. When it goes, a listener loses what it has not received."""
