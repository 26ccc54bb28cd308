"""Interrupt long work at checkpoints. Standard library only.

Long work calls `checkpoint` often, at least every few milliseconds. Usually that does nothing. In the language server,
the work waits there while messages are read.
"""

from __future__ import annotations

from collections.abc import Callable

_interrupt: Callable[[], None] | None = None


def checkpoint() -> None:
    """Let other work interrupt this one, which may never continue."""
    if _interrupt:
        _interrupt()


def on_checkpoint(interrupt: Callable[[], None] | None) -> None:
    """Set the function that each checkpoint calls, on whichever thread; None for nothing."""
    global _interrupt
    _interrupt = interrupt
