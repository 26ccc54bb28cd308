"""Wait for what nothing reports: look again until it holds."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

LIMIT = 120.0
"""Seconds on a busy machine."""

T = TypeVar("T")


def until(what: Callable[[], T], problem: Callable[[], object] = lambda: "it didn't happen in time") -> T:
    """Wait for something to be true, and return it. Raises AssertionError with the problem if it takes too long."""
    end, pause = time.monotonic() + LIMIT, 0.001
    while not (found := what()):
        assert time.monotonic() < end, problem()
        time.sleep(pause)
        pause = min(2 * pause, 0.1)  # some looks start a process
    return found
