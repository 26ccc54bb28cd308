"""Interrupt long work at checkpoints. Standard library only.

Long work calls `checkpoint` often, at least every few milliseconds. Usually that does nothing. In the language server,
the work waits there while messages are read.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

T = TypeVar("T")
FEW = 100
"""Items between two checkpoints of `in_slices`: work on each takes a few microseconds, up to a hundred."""


class _Here(threading.local):
    """The function that each checkpoint of this thread calls."""

    interrupt: Callable[[], None] | None = None


class _OverError(BaseException):
    """Nobody waits for the result of work any more."""


_here = _Here()


def checkpoint() -> None:
    """Let other work interrupt the caller's, which may never continue."""
    if _here.interrupt:
        _here.interrupt()


def in_slices(items: Iterable[T]) -> Iterator[T]:
    """Yield items, with a checkpoint after every few."""
    for number, item in enumerate(items):
        if not number % FEW:
            checkpoint()
        yield item


def on_checkpoint(interrupt: Callable[[], None] | None) -> None:
    """Set the function that each checkpoint of this thread calls; None for nothing."""
    _here.interrupt = interrupt


def keep_collections_short() -> None:
    """Exempt all objects that exist from garbage collections, which can't be interrupted.

    Each later one looks through 20,000 new objects: that takes 0.01 s. Older ones are looked through after 50 million
    new ones: hardly any is in a cycle.
    """
    gc.freeze()
    gc.set_threshold(20_000, 2_500, 0)


def unless(is_over: Callable[[], bool], work: Callable[[], T]) -> T | None:
    """Return the result of work, or None as soon as it `is_over` at one of its checkpoints. Others may interrupt it,
    too."""
    before = _here.interrupt

    def look() -> None:
        if before:
            before()
        if is_over():
            raise _OverError

    on_checkpoint(look)
    try:
        return work()
    except _OverError:
        return None
    finally:
        on_checkpoint(before)
