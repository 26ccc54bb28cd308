"""Improv: live coding for robot motion. This package needs no editor and no robot."""

import time

__version__ = "0.1.0"
STARTED = time.monotonic()
"""When this process began to run code of ours, in monotonic seconds: our modules are imported after this one."""


class LineError(Exception):
    """Something that can't be done. The message is one line for people that says why, and what to do about it."""
