"""Where long work can be interrupted. Standard library only.

Work that may take long calls `checkpoint` often, at least every few milliseconds. Usually nothing happens then. The
language server sets what does: there, the work waits while messages are read.
"""

from __future__ import annotations

from collections.abc import Callable

_interrupt: Callable[[], None] | None = None


def checkpoint() -> None:
    """The work that calls this may be interrupted here, and may never be continued."""
    if _interrupt:
        _interrupt()


def on_checkpoint(interrupt: Callable[[], None] | None) -> None:
    """Set what happens at each checkpoint, on whichever thread; None for nothing."""
    global _interrupt
    _interrupt = interrupt
