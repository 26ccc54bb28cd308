"""Measures for how long the machine has slept: its monotonic clock stands still meanwhile, but robots may keep
moving."""

from __future__ import annotations

import sys
import time

NOTICED = 0.1
"""Seconds that count as sleep. A caller that compares two readings of `asleep` has to allow for their errors."""
_EXACT = 0.01
"""Seconds that may pass while the clocks are read: the largest error."""
_TRIES = 10


def asleep() -> float:
    """Return the seconds for which the machine has slept since it was started; always 0 on systems that don't report
    it, which are all but Linux."""
    if sys.platform != "linux":
        return 0.0
    for _ in range(_TRIES):
        before, with_sleep = time.monotonic(), time.clock_gettime(time.CLOCK_BOOTTIME)
        if time.monotonic() < before + _EXACT:  # otherwise, other processes ran in between
            break
    return with_sleep - before
