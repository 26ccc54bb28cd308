"""Saves of a program by any editor: its state in the file, its changes, and when a save is complete."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import NamedTuple

from improv_core.program.files import ReadError, read_program, read_robots_file, without_ending
from improv_core.robots.config import find_robots_file

STEP, LOOK_AGAIN = 10, 500
"""Milliseconds from a change in a watched folder to a check of the file, and between checks without a change."""
SETTLING, MID_LINE_SETTLING, EMPTY_SETTLING = 0.1, 0.5, 5.0
"""Seconds that a file must stay unchanged before it plays: longer if it ends in the middle of a line, since it may be
half written, and longest if it is empty, missing or not text, since somebody may still be writing it. This also holds
for an `improv.toml` that has changed: without it, robots have no limits."""


class Saved(NamedTuple):
    """A program as it was saved, or why it can't be read; the text of its `improv.toml`, if that can be read; and the
    times in ns when both were saved.

    So a save that changes nothing counts as well.
    """

    text: str | None
    problem: str
    robots: str | None
    times: tuple[int, ...]


def read_saved(path: Path) -> Saved:
    """Read a program as it is saved now."""
    robots_file = find_robots_file(path.parent)
    robots, times = None, []
    for file in (path, robots_file):
        with contextlib.suppress(OSError):
            if file:
                times.append(file.stat().st_mtime_ns)
    with contextlib.suppress(ReadError):
        robots = read_robots_file(robots_file) if robots_file else None
    try:
        return Saved(read_program(path), "", robots, tuple(times))
    except ReadError as problem:
        return Saved(None, str(problem), robots, tuple(times))


def saved_or_awaited(path: Path) -> Saved:
    """Read a program, or none if it is missing from a folder that exists. Raises ReadError."""
    saved = read_saved(path)
    if saved.text is None and (path.exists() or not path.parent.is_dir() or without_ending(path)):
        raise ReadError(saved.problem)
    return saved


async def changes(folder: Path) -> AsyncIterator[object]:
    """Yield whenever a folder may have changed; it may be removed and come back.

    A folder that can't be watched is polled.
    """
    from watchfiles import awatch

    # The folder is watched instead of the file, since many editors save by replacing the file. Polling finds changes
    # that the system did not report: saves before watching began, and saves over a network.
    while True:
        with contextlib.suppress(OSError):
            async for found in awatch(
                folder, recursive=False, yield_on_timeout=True, step=STEP, rust_timeout=LOOK_AGAIN
            ):
                yield found
        await asyncio.sleep(LOOK_AGAIN / 1000)
        yield None


async def settle(
    path: Path,
    before: Saved,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
) -> Saved:
    """Return a program once neither it nor its `improv.toml` changes any more: half of one may be a program too, and
    not every editor saves in one step. `before` is how it was."""
    latest, since = read_saved(path), clock()
    while clock() - since < _settling(latest, before):
        await sleep(SETTLING)
        if (now := read_saved(path)) != latest:
            latest, since = now, clock()
    return latest


def _settling(saved: Saved, before: Saved) -> float:
    texts = [saved.text] if saved.robots == before.robots else [saved.text, saved.robots]
    return max(map(_settling_of, texts))


def _settling_of(text: str | None) -> float:
    if not text:
        return EMPTY_SETTLING
    return SETTLING if text.endswith(("\n", "\r")) else MID_LINE_SETTLING
