"""Processes that are not our children: who they are, and when they end (Linux)."""

from __future__ import annotations

import os
import select
import time
from pathlib import Path


def descendants(pid: int) -> dict[int, int]:
    """All processes below this one, each with a descriptor that stays its own after its number is used again."""
    found: dict[int, int] = {}
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, task.read_text().split()):
            found[child] = os.pidfd_open(child)
            found.update(descendants(child))
    return found


def wait_until_gone(processes: dict[int, int], limit: float) -> None:
    """Wait until all have ended. Raises AssertionError if one still runs after `limit` seconds."""
    end = time.monotonic() + limit
    for pid, descriptor in processes.items():
        poll = select.poll()
        poll.register(descriptor, select.POLLIN)
        assert poll.poll(max(end - time.monotonic(), 0) * 1000), f"process {pid} still runs after {limit} s"
        os.close(descriptor)
