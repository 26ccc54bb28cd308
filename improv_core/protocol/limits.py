"""Limits that a stage and its parent share, and the folder of the stage. The far end of a link needs nothing else of
the protocol, and little memory. Standard library only."""

from __future__ import annotations

import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "stage"
"""The path that Python gets to run a stage."""
SILENCE_LIMIT = 0.5
"""Seconds without a ping after which a stage with real robots considers its parent hung, and stops the robots, unless
its parent asks for more patience."""
MAX_AHEAD = 2.0
"""Seconds by which a request may come before the time at which it takes effect. A later time counts as now."""
HANG_LIMIT = 0.9
"""Seconds without an answer after which a stage that moves real robots counts as hung. With the ping period, that takes
at most 1 s. Less would stop healthy stages on a busy machine."""
LOADING_LIMIT = 10.0
"""Seconds that either side may need for a new score: to read a long one, or to make a thousand robots' publishers."""
DEADMAN_LIMIT = 0.3
"""Seconds without a sign of a deadman button after which it counts as released."""
END_LIMIT = 3.0
"""Seconds a stage may take to stop its robots and end, before it is killed."""
LONGEST_LINE = 64_000_000
"""The most bytes of a line: four times as many as the score of a program of 100,000 lines takes."""
MEASURED_AT_REST = 1.0
"""Seconds for which robots are still measured after they were sent zeros: most have come to rest by then."""
STOP_PIPE = "IMPROV_STOP_PIPE"
"""The environment variable with the file descriptor of a stage's channel of stops."""
STOP_SOCKETS = "IMPROV_STOP_SOCKETS"
"""The environment variable with the path with which the names of a performance's stop sockets begin. Each stage has its
own socket (safety/stage_stops.py)."""


def helper_command(name: str, *arguments: str) -> list[str]:
    """Return the command that starts a helper process of a stage: the module of this name, such as `music.osc`."""
    return [sys.executable, str(FOLDER), name, *arguments]
