"""Keys that are pressed in the terminal while something plays."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping


@contextlib.contextmanager
def pressed(keys: Mapping[str, Callable[[], None]]) -> Iterator[bool]:
    """Call a key's function when somebody presses it, without Enter. Only in a terminal, and not in the background.

    Yield whether it does that.
    """
    if os.name == "nt" or not (sys.stdin and sys.stdin.isatty()) or not _in_front(sys.stdin.fileno()):
        yield False
        return
    import termios
    import tty

    terminal, loop = sys.stdin.fileno(), asyncio.get_running_loop()
    before = termios.tcgetattr(terminal)

    def read() -> None:
        typed = os.read(terminal, 1024).decode(errors="replace")
        if not typed:  # the terminal is gone
            loop.remove_reader(terminal)
        for key in typed:
            if act := keys.get(key):
                act()

    tty.setcbreak(terminal, termios.TCSANOW)  # Ctrl-C still interrupts
    loop.add_reader(terminal, read)
    try:
        yield True
    finally:
        loop.remove_reader(terminal)
        with contextlib.suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(terminal, termios.TCSANOW, before)


def _in_front(terminal: int) -> bool:
    """Return whether a terminal's input is for this process: not in the background, nor in a session without the
    terminal."""
    try:
        return os.tcgetpgrp(terminal) == os.getpgrp()
    except OSError:  # the terminal of another session, for example after `setsid`
        return False
