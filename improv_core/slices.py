"""Interrupt long work at checkpoints. Standard library only.

Long work calls `checkpoint` often, at least every few milliseconds. Usually that does nothing. In the language server,
the work waits there while messages are read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
FEW = 100
"""Items between two checkpoints of `in_slices`: work on each takes a few microseconds, up to a hundred."""
_interrupt: Callable[[], None] | None = None


def checkpoint() -> None:
    """Let other work interrupt this one, which may never continue."""
    if _interrupt:
        _interrupt()


def in_slices(items: Iterable[T]) -> Iterator[T]:
    """Yield items, with a checkpoint after every few."""
    for number, item in enumerate(items):
        if not number % FEW:
            checkpoint()
        yield item


def on_checkpoint(interrupt: Callable[[], None] | None) -> None:
    """Set the function that each checkpoint calls, on whichever thread; None for nothing."""
    global _interrupt
    _interrupt = interrupt
