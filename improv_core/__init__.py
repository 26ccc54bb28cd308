"""Improv: live coding for robot motion. This package needs no editor and no robot."""

import time

__version__ = "0.1.0"
STARTED = time.monotonic()
"""When this process began to run code of ours, in monotonic seconds: our modules are imported after this one."""


class LineError(Exception):
    """An error about something that can't be done. Its message is one line for people: why, and what to do about it."""
